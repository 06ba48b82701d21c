//! A picture is a list of shapes. It is written as SVG here, and painted as pixels in `pixels.rs`.

use crate::table::escape;
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
const INK: Colour = Colour::hex(0x1f2328);
/// The colour of secondary text.
const MUTED: Colour = Colour::hex(0x656d76);

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

    /// Returns the picture as an SVG file on white paper.
    pub(super) fn to_svg(&self, size: impl Into<Place>, title: &str) -> String {
        let [width, height] = size.into().in_plane();
        let title = escape(title);
        let shapes: String = self.shapes.iter().map(element).collect();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             width=\"{width:.0}\" height=\"{height:.0}\" role=\"img\" \
             font-family=\"system-ui, 'Segoe UI', Helvetica, Arial, sans-serif\" fill=\"none\" \
             stroke-linecap=\"round\" stroke-linejoin=\"round\">\n<title>{title}</title>\n\
             <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>\n{shapes}</svg>\n"
        )
    }
}

fn element(shape: &Shape) -> String {
    match shape {
        Shape::Line(points, pen) => {
            let point = |point: &Place| format!("{:.1},{:.1}", point.forward(), point.up());
            let points: Vec<String> = points.iter().map(point).collect();
            format!(
                "<polyline points=\"{}\"{}/>\n",
                points.join(" "),
                stroke(pen)
            )
        }
        Shape::Disc(middle, radius, fill, edge) => {
            let [x, y] = middle.in_plane();
            let style = paint("fill", *fill) + &stroke(edge);
            format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"{style}/>\n")
        }
        Shape::Rectangle(corner, size, fill) => {
            let ([x, y], [width, height]) = (corner.in_plane(), size.in_plane());
            let size = format!("width=\"{width:.1}\" height=\"{height:.1}\"");
            let fill = paint("fill", *fill);
            format!("<rect x=\"{x:.1}\" y=\"{y:.1}\" {size}{fill}/>\n")
        }
        Shape::Text(place, text, font) => {
            let ([x, y], text) = (place.in_plane(), escape(text));
            let (colour, style) = match font {
                Font::Plain => (INK, ""),
                Font::Bold => (INK, " font-weight=\"600\""),
                Font::End => (INK, " text-anchor=\"end\""),
                Font::Caption => (MUTED, " text-anchor=\"middle\""),
            };
            let fill = paint("fill", colour);
            format!("<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"12\"{fill}{style}>{text}</text>\n")
        }
    }
}

fn stroke(pen: &Pen) -> String {
    if pen.width == 0.0 {
        return String::new();
    }
    let (colour, width) = (paint("stroke", pen.colour), pen.width);
    format!("{colour} stroke-width=\"{width:.1}\"")
}

/// Returns the SVG attribute `name` (which is `fill` or `stroke`) with a colour.
fn paint(name: &str, colour: Colour) -> String {
    let [r, g, b] = colour.rgb;
    format!(" {name}=\"#{r:02x}{g:02x}{b:02x}\"")
}
