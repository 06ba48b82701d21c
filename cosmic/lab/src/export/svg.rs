//! The flat pattern as SVG, to scale: one unit of the drawing is a millimetre.

use super::pattern::{LABEL, Layer, Part, Pattern};
use cosmic::geometry::Vector;
use std::fmt::Write;

/// The colours of skeleton, actuators and labels. A laser cutter's program tells the three apart by these colours.
const SKELETON: &str = "#000000";
const ACTUATOR: &str = "#0000ff";
const LABELS: &str = "#00a000";

/// Returns the pattern as the text of an SVG file. Coordinates are rounded to a nanometre.
pub(super) fn draw(pattern: &Pattern) -> String {
    let [width, height] = pattern.size.array();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.6}mm\" height=\"{height:.6}mm\" \
         viewBox=\"0 0 {width:.6} {height:.6}\" fill=\"none\" stroke-width=\"0.1\" \
         font-family=\"sans-serif\">\n<title>Flat pattern, millimetres to 6 decimals</title>\n"
    );
    for (number, layer) in pattern.layers.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = writeln!(svg, "<g id=\"layer-{}\">", number + 1);
        draw_layer(&mut svg, pattern, layer, number + 1);
        svg += "</g>\n";
    }
    svg + "</svg>\n"
}

fn draw_layer(svg: &mut String, pattern: &Pattern, layer: &Layer, number: usize) {
    for (class, colour, is_actuator) in
        [("skeleton", SKELETON, false), ("actuator", ACTUATOR, true)]
    {
        let _ = writeln!(svg, "<g class=\"{class}\" stroke=\"{colour}\">");
        let own = layer.parts.iter().filter(|p| p.is_actuator == is_actuator);
        for part in own {
            draw_part(svg, pattern, part);
        }
        *svg += "</g>\n";
    }
    let _ = writeln!(svg, "<g class=\"labels\" fill=\"{LABELS}\">");
    let [x, y] = down(pattern, layer.label).array();
    let _ = writeln!(
        svg,
        "<text x=\"{x:.6}\" y=\"{y:.6}\" font-size=\"{LABEL}\">layer {number}</text>"
    );
    for part in &layer.parts {
        let [x, y] = down(pattern, part.axis.middle()).array();
        let _ = writeln!(
            svg,
            "<text transform=\"translate({x:.6} {y:.6}) rotate({:.6})\" font-size=\"{:.6}\" \
             text-anchor=\"middle\" dominant-baseline=\"central\">{}</text>",
            -part.angle,
            pattern.label_height(),
            part.label()
        );
    }
    *svg += "</g>\n";
}

/// Converts a point of the pattern to coordinates of SVG, whose second axis points down.
fn down(pattern: &Pattern, point: Vector<f64>) -> Vector<f64> {
    point.with_up(pattern.size.up() - point.up())
}

/// Draws the outline of a bar and its two holes.
fn draw_part(svg: &mut String, pattern: &Pattern, part: &Part) {
    let [a, b, c, d] = part.corners.map(|corner| {
        let [x, y] = down(pattern, corner).array();
        format!("{x:.6} {y:.6}")
    });
    let (half, hole) = (0.5 * pattern.sizes.width, 0.5 * pattern.sizes.hole);
    let arc = |to| format!("A {half:.6} {half:.6} 0 0 0 {to}");
    let _ = writeln!(
        svg,
        "<g id=\"bar-{}\"><path d=\"M {a} L {b} {} L {d} {} Z\"/>",
        part.edge,
        arc(&c),
        arc(&a)
    );
    for end in [part.axis.from, part.axis.to] {
        let [x, y] = down(pattern, end).array();
        let _ = write!(svg, "<circle cx=\"{x:.6}\" cy=\"{y:.6}\" r=\"{hole:.6}\"/>");
    }
    *svg += "</g>\n";
}
