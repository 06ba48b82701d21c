//! A picture is a list of shapes. It is written as SVG or painted as pixels.

use cosmic::geometry::Vector;

/// A position or a size in a picture, in pixels. The first coordinate points to the right, the second downwards.
pub type Place = Vector<f64>;

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// Red, green and blue.
    pub rgb: [u8; 3],
}

impl Colour {
    /// Returns the colour `0xRRGGBB`.
    pub(super) const fn hex(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self { rgb: [r, g, b] }
    }

    /// Returns the mixture of this colour and `other`. `share` is the fraction of `other`, from 0 to 1.
    pub(super) fn mixed(self, other: Self, share: f64) -> Self {
        let mix = |k: usize| {
            let (from, to) = (f64::from(self.rgb[k]), f64::from(other.rgb[k]));
            (from + share * (to - from)).round() as u8
        };
        Self {
            rgb: [0, 1, 2].map(mix),
        }
    }
}

pub(super) const PAPER: Colour = Colour::hex(0xffffff);
/// The colour of text and axes.
pub(super) const INK: Colour = Colour::hex(0x1f2328);
/// The colour of secondary text.
pub(super) const MUTED: Colour = Colour::hex(0x656d76);

/// The style of a line.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    pub(super) colour: Colour,
    /// The width in pixels.
    pub(super) width: f64,
}

impl Pen {
    pub(super) const fn new(colour: Colour, width: f64) -> Self {
        Self { colour, width }
    }
}

/// The style of a text.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Font {
    /// Text that begins at its place.
    Plain,
    /// Bold text that begins at its place.
    Bold,
    /// Text that ends at its place.
    End,
    /// Muted text around its place.
    Caption,
}

/// A part of a picture.
pub(super) enum Shape {
    Line(Vec<Place>, Pen),
    /// A disc: its middle, its radius, its fill and its edge.
    Disc(Place, f64, Colour, Pen),
    /// A rectangle: its upper left corner, its size and its fill.
    Rectangle(Place, Place, Colour),
    /// A text: the place on its baseline, the letters and the font.
    Text(Place, String, Font),
}

/// A picture under construction. Later shapes cover earlier ones.
#[derive(Default)]
pub(super) struct Picture {
    pub(super) shapes: Vec<Shape>,
}

impl Picture {
    /// Draws a line through points. In SVG, a line through a single point is a dot.
    pub(super) fn line<P: Into<Place>>(&mut self, points: impl IntoIterator<Item = P>, pen: Pen) {
        let points = points.into_iter().map(Into::into).collect();
        self.shapes.push(Shape::Line(points, pen));
    }

    pub(super) fn disc(&mut self, middle: impl Into<Place>, radius: f64, fill: Colour, edge: Pen) {
        let disc = Shape::Disc(middle.into(), radius, fill, edge);
        self.shapes.push(disc);
    }

    pub(super) fn rectangle<P: Into<Place>>(&mut self, corner: P, size: P, fill: Colour) {
        let rectangle = Shape::Rectangle(corner.into(), size.into(), fill);
        self.shapes.push(rectangle);
    }

    pub(super) fn text(&mut self, place: impl Into<Place>, text: impl Into<String>, font: Font) {
        let text = Shape::Text(place.into(), text.into(), font);
        self.shapes.push(text);
    }
}
