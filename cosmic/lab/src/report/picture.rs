//! A picture is a list of shapes. It is written as SVG or painted as pixels.

use cosmic::geometry::Vector;

/// A position or a size in a picture, in pixels. The first coordinate points to the right, the second downwards.
pub type Place = Vector<f64>;

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// Red, green and blue.
    pub rgb: [u8; 3],
    /// The opacity, from 0 (invisible) to 1 (opaque).
    pub opacity: f64,
}

impl Colour {
    /// Returns the opaque colour `0xRRGGBB`.
    pub(super) const fn hex(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self {
            rgb: [r, g, b],
            opacity: 1.0,
        }
    }

    /// Returns the opaque mixture of this colour and `other`. `share` is the fraction of `other`, from 0 to 1.
    pub(super) fn mixed(self, other: Self, share: f64) -> Self {
        let mix = |k: usize| {
            let (from, to) = (f64::from(self.rgb[k]), f64::from(other.rgb[k]));
            (from + share * (to - from)).round() as u8
        };
        Self {
            rgb: [0, 1, 2].map(mix),
            opacity: 1.0,
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
    pub colour: Colour,
    /// The width in pixels.
    pub(super) width: f64,
    /// The lengths of dashes and gaps in turn, in pixels, written as in SVG; empty for a solid line.
    pub(super) dashes: &'static str,
}

impl Pen {
    pub(super) const fn new(colour: Colour, width: f64) -> Self {
        Self::dashed(colour, width, "")
    }

    pub(super) const fn dashed(colour: Colour, width: f64, dashes: &'static str) -> Self {
        Self {
            colour,
            width,
            dashes,
        }
    }
}

/// The style of a text.
#[derive(Clone, Copy)]
pub struct Font {
    /// The colour.
    pub colour: Colour,
    /// The fraction of the text's width that is to the left of its place: 0, 0.5 or 1.
    pub anchor: f64,
    /// True for bold text.
    pub bold: bool,
    /// The size in pixels.
    pub size: f64,
}

impl Font {
    /// Plain text of 12 pixels that begins at its place.
    pub const PLAIN: Self = Self {
        colour: INK,
        anchor: 0.0,
        bold: false,
        size: 12.0,
    };
    pub(super) const BOLD: Self = Self {
        bold: true,
        ..Self::PLAIN
    };
    pub(super) const MUTED: Self = Self {
        colour: MUTED,
        ..Self::PLAIN
    };
    pub(super) const END: Self = Self::PLAIN.at(1.0);
    pub(super) const CAPTION: Self = Self::MUTED.at(0.5);

    /// Returns this style with another anchor.
    pub const fn at(self, anchor: f64) -> Self {
        Self { anchor, ..self }
    }
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
