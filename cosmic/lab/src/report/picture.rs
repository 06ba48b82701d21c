//! A picture as a list of shapes. It is written as SVG or painted as pixels.

use cosmic::geometry::Vector;

/// A place or a size in a picture: pixels from the left and from the top.
pub(super) type Place = Vector<f64>;

/// A colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour {
    /// Red, green and blue.
    pub rgb: [u8; 3],
    /// From 0, invisible, to 1, opaque.
    pub opacity: f64,
}

impl Colour {
    /// The opaque colour `0xRRGGBB`.
    pub(super) const fn hex(rgb: u32) -> Self {
        let [_, r, g, b] = rgb.to_be_bytes();
        Self {
            rgb: [r, g, b],
            opacity: 1.0,
        }
    }

    /// The colour with another opacity.
    pub(super) const fn faint(self, opacity: f64) -> Self {
        Self { opacity, ..self }
    }

    /// The opaque colour between this one (share 0) and another (share 1).
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
/// Text and axes.
pub(super) const INK: Colour = Colour::hex(0x1f2328);
/// Secondary text.
pub(super) const MUTED: Colour = Colour::hex(0x656d76);
/// Grid lines of charts.
pub(super) const RULE: Colour = Colour::hex(0xd8dee4);

/// The style of a line.
#[derive(Clone, Copy)]
pub(super) struct Pen {
    pub(super) colour: Colour,
    /// Pixels.
    pub(super) width: f64,
    /// Lengths of dashes and gaps in turn, pixels, as in SVG; empty for a solid line.
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

/// The point of a text that is at its place.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The style of a text.
#[derive(Clone, Copy)]
pub(super) struct Font {
    pub(super) colour: Colour,
    pub(super) anchor: Anchor,
    pub(super) bold: bool,
    /// Pixels.
    pub(super) size: f64,
}

impl Font {
    pub(super) const PLAIN: Self = Self {
        colour: INK,
        anchor: Anchor::Start,
        bold: false,
        size: 12.0,
    };
    pub(super) const BOLD: Self = Self {
        bold: true,
        ..Self::PLAIN
    };
    pub(super) const END: Self = Self::PLAIN.at(Anchor::End);
    pub(super) const MIDDLE: Self = Self::PLAIN.at(Anchor::Middle);
    pub(super) const MUTED: Self = Self {
        colour: MUTED,
        ..Self::PLAIN
    };
    pub(super) const CAPTION: Self = Self::MUTED.at(Anchor::Middle);

    pub(super) const fn at(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }
}

/// A part of a picture. Later shapes cover earlier ones.
pub(super) enum Shape {
    Line {
        points: Vec<Place>,
        pen: Pen,
    },
    Disc {
        middle: Place,
        radius: f64,
        fill: Colour,
        edge: Pen,
    },
    Rectangle {
        corner: Place,
        size: Place,
        fill: Colour,
    },
    /// The place is on the baseline.
    Text {
        place: Place,
        text: String,
        font: Font,
    },
}

/// A picture under construction.
#[derive(Default)]
pub(super) struct Picture {
    pub(super) shapes: Vec<Shape>,
}

impl Picture {
    /// Draws a line through points. In SVG, one point alone is a dot.
    pub(super) fn line<P: Into<Place>>(&mut self, points: impl IntoIterator<Item = P>, pen: Pen) {
        let points = points.into_iter().map(Into::into).collect();
        self.shapes.push(Shape::Line { points, pen });
    }

    pub(super) fn disc(&mut self, middle: impl Into<Place>, radius: f64, fill: Colour, edge: Pen) {
        self.shapes.push(Shape::Disc {
            middle: middle.into(),
            radius,
            fill,
            edge,
        });
    }

    /// Draws a disc without an edge.
    pub(super) fn dot(&mut self, middle: impl Into<Place>, radius: f64, fill: Colour) {
        self.disc(middle, radius, fill, Pen::new(fill, 0.0));
    }

    pub(super) fn rectangle(
        &mut self,
        corner: impl Into<Place>,
        size: impl Into<Place>,
        fill: Colour,
    ) {
        self.shapes.push(Shape::Rectangle {
            corner: corner.into(),
            size: size.into(),
            fill,
        });
    }

    pub(super) fn text(&mut self, place: impl Into<Place>, text: impl Into<String>, font: Font) {
        self.shapes.push(Shape::Text {
            place: place.into(),
            text: text.into(),
            font,
        });
    }
}
