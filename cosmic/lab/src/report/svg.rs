//! Pictures as SVG.

use super::picture::{Anchor, Colour, Pen, Picture, Place, Shape};
use crate::table::escape;

impl Picture {
    /// The picture as an SVG file on white paper.
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
        Shape::Line { points, pen } => {
            let points: String = points.iter().map(|point| place(*point) + " ").collect();
            format!(
                "<polyline points=\"{}\"{}/>\n",
                points.trim_end(),
                stroke(pen)
            )
        }
        Shape::Disc {
            middle,
            radius,
            fill,
            edge,
        } => {
            let ([x, y], fill) = (middle.array(), paint("fill", *fill));
            let edge = stroke(edge);
            format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\"{fill}{edge}/>\n")
        }
        Shape::Rectangle { corner, size, fill } => {
            let ([x, y], [width, height]) = (corner.array(), size.array());
            let fill = paint("fill", *fill);
            format!(
                "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"{fill}/>\n"
            )
        }
        Shape::Text { place, text, font } => {
            let ([x, y], fill) = (place.array(), paint("fill", font.colour));
            let anchor = match font.anchor {
                Anchor::Start => "",
                Anchor::Middle => " text-anchor=\"middle\"",
                Anchor::End => " text-anchor=\"end\"",
            };
            let weight = if font.bold {
                " font-weight=\"600\""
            } else {
                ""
            };
            let (size, text) = (font.size, escape(text));
            format!(
                "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\"{fill}{anchor}{weight}>{text}</text>\n"
            )
        }
    }
}

fn place(point: Place) -> String {
    let [x, y] = point.array();
    format!("{x:.1},{y:.1}")
}

fn stroke(pen: &Pen) -> String {
    if pen.width == 0.0 {
        return String::new();
    }
    let dashes = match pen.dashes {
        "" => String::new(),
        lengths => format!(" stroke-dasharray=\"{lengths}\""),
    };
    let (colour, width) = (paint("stroke", pen.colour), pen.width);
    format!("{colour} stroke-width=\"{width:.1}\"{dashes}")
}

/// The attribute `name`, which is `fill` or `stroke`, with its opacity.
fn paint(name: &str, colour: Colour) -> String {
    let [r, g, b] = colour.rgb;
    let opacity = match colour.opacity {
        1.0 => String::new(),
        opacity => format!(" {name}-opacity=\"{opacity}\""),
    };
    format!(" {name}=\"#{r:02x}{g:02x}{b:02x}\"{opacity}")
}
