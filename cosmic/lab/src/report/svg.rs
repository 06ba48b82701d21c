//! Writes pictures as SVG.

use super::picture::{Colour, Font, INK, MUTED, Pen, Picture, Place, Shape};
use crate::table::escape;

impl Picture {
    /// Returns the picture as an SVG file on white paper.
    pub(super) fn to_svg(&self, size: impl Into<Place>, title: &str) -> String {
        let [width, height] = size.into().array();
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
            let point = |point: &Place| format!("{:.1},{:.1}", point[0], point[1]);
            let points: Vec<String> = points.iter().map(point).collect();
            format!(
                "<polyline points=\"{}\"{}/>\n",
                points.join(" "),
                stroke(pen)
            )
        }
        Shape::Disc(middle, radius, fill, edge) => {
            let [x, y] = middle.array();
            let style = paint("fill", *fill) + &stroke(edge);
            format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"{style}/>\n")
        }
        Shape::Rectangle(corner, size, fill) => {
            let ([x, y], [width, height]) = (corner.array(), size.array());
            let size = format!("width=\"{width:.1}\" height=\"{height:.1}\"");
            let fill = paint("fill", *fill);
            format!("<rect x=\"{x:.1}\" y=\"{y:.1}\" {size}{fill}/>\n")
        }
        Shape::Text(place, text, font) => {
            let ([x, y], text) = (place.array(), escape(text));
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
