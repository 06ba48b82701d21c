//! Drawings as SVG text. Coordinates are pixels, y downwards. Styles are attributes, copied into the
//! file.

use crate::table::escape;
use cosmic::geometry::Vector;
use std::fmt::Write;

/// Colour of text and axes.
pub(super) const INK: &str = "#1f2328";
/// Colour of secondary text.
pub(super) const MUTED: &str = "#656d76";
/// Lines in the colour of axes, of secondary text, and of rulings.
pub(super) const INK_LINE: &str = r##"stroke="#1f2328""##;
pub(super) const MUTED_LINE: &str = r##"stroke="#656d76""##;
pub(super) const RULE_LINE: &str = r##"stroke="#d8dee4""##;
/// Headings, texts that end at their place or have their middle there, and secondary texts.
pub(super) const BOLD: &str = r#"font-weight="600""#;
pub(super) const END: &str = r#"text-anchor="end""#;
pub(super) const MIDDLE: &str = r#"text-anchor="middle""#;
pub(super) const MUTED_END: &str = r##"text-anchor="end" fill="#656d76""##;
pub(super) const MUTED_MIDDLE: &str = r##"text-anchor="middle" fill="#656d76""##;

/// A place or a size in the drawing, pixels.
type Place = Vector<f64>;

/// A drawing under construction.
#[derive(Default)]
pub(super) struct Svg {
    body: String,
}

impl Svg {
    /// An element without content.
    fn element(&mut self, name: &str, attributes: std::fmt::Arguments, style: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.body, "<{name} {attributes} {style}/>");
    }

    pub(super) fn line(&mut self, from: impl Into<Place>, to: impl Into<Place>, style: &str) {
        let ([x1, y1], [x2, y2]) = (from.into().array(), to.into().array());
        let ends = format_args!(r#"x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}""#);
        self.element("line", ends, style);
    }

    pub(super) fn rect(&mut self, corner: impl Into<Place>, size: impl Into<Place>, style: &str) {
        let ([x, y], [width, height]) = (corner.into().array(), size.into().array());
        let place =
            format_args!(r#"x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{height:.1}""#);
        self.element("rect", place, style);
    }

    pub(super) fn circle(&mut self, middle: impl Into<Place>, radius: f64, style: &str) {
        let [x, y] = middle.into().array();
        let place = format_args!(r#"cx="{x:.1}" cy="{y:.1}" r="{radius:.1}""#);
        self.element("circle", place, style);
    }

    /// A line through points. One point shows as a dot if the style has round caps.
    pub(super) fn polyline(&mut self, points: &[Place], style: &str) {
        let place = |point: &Place| {
            let [x, y] = point.array();
            format!("{x:.1},{y:.1}")
        };
        let places = points.iter().map(place);
        let points = places.collect::<Vec<_>>().join(" ");
        let points = format_args!(r#"points="{points}" fill="none""#);
        self.element("polyline", points, style);
    }

    /// A line of text; its anchor (`start`, `middle`, `end`) is part of the style.
    pub(super) fn text(&mut self, place: impl Into<Place>, text: &str, style: &str) {
        let [x, y] = place.into().array();
        let text = escape(text);
        let _ = writeln!(
            self.body,
            r#"<text x="{x:.1}" y="{y:.1}" {style}>{text}</text>"#
        );
    }

    /// A group with common attributes; `draw` fills it.
    pub(super) fn group(&mut self, attributes: &str, draw: impl FnOnce(&mut Self)) {
        let _ = writeln!(self.body, "<g {attributes}>");
        draw(self);
        self.body.push_str("</g>\n");
    }

    /// The finished file, of this width and height.
    pub(super) fn finish(self, size: impl Into<Place>, title: &str) -> String {
        let [width, height] = size.into().array();
        let title = escape(title);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             width=\"{width:.0}\" height=\"{height:.0}\" role=\"img\" \
             font-family=\"system-ui, 'Segoe UI', Helvetica, Arial, sans-serif\" font-size=\"12\" \
             fill=\"{INK}\">\n<title>{title}</title>\n\
             <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#fff\"/>\n{}</svg>\n",
            self.body
        )
    }
}
