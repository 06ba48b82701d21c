//! Charts with logarithmic axes, for errors against costs.

use cosmic::geometry::{Range, Vector};

use super::plot::{Axes, Axis};
use super::svg::{BOLD, MUTED, Svg};

pub use super::plot::Line;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 50.0;
/// Room for the names of the lines.
const NAMES: f64 = 270.0;

/// Lines over two logarithmic axes, in a file `name.svg`.
#[derive(Clone, Debug, PartialEq)]
pub struct LogChart {
    /// Its file's name.
    pub name: &'static str,
    /// Its caption.
    pub caption: String,
    /// Its heading: the quantity upwards, with its unit.
    pub title: String,
    /// The quantity along, with its unit.
    pub along: String,
    /// The lines.
    pub lines: Vec<Line>,
    /// A point with a ring, and its name.
    pub marked: Option<(Vector<f64>, String)>,
}

impl LogChart {
    /// The chart as an SVG file.
    pub fn draw(&self) -> String {
        let axes = Axes {
            origin: Vector::new([LEFT, TOP]),
            size: Vector::new([WIDTH - LEFT - NAMES, HEIGHT - TOP - 50.0]),
            x: self.axis(Vector::forward),
            y: self.axis(Vector::up),
        };
        let mut svg = Svg::default();
        axes.draw(&mut svg, &self.title);
        axes.draw_along(&mut svg, &self.along);
        for (k, line) in self.lines.iter().enumerate() {
            let places: Vec<Vector<f64>> = shown(line).map(|p| axes.place(p)).collect();
            let stroke = line.stroke();
            svg.polyline(&places, &stroke);
            for place in places {
                svg.circle(place, 2.6, &format!(r#"fill="{}""#, line.colour));
            }
            let [x, y] = [WIDTH - NAMES + 20.0, TOP + 8.0 + 19.0 * k as f64];
            svg.line([x, y - 4.0], [x + 26.0, y - 4.0], &stroke);
            svg.text([x + 34.0, y], &line.name, "");
        }
        if let Some((point, name)) = &self.marked {
            let place = axes.place(*point);
            let ring = r##"fill="none" stroke="#1f2328" stroke-width="1.6""##;
            svg.circle(place, 8.0, ring);
            svg.text(place + Vector::new([12.0, -10.0]), name, BOLD);
        }
        let note = [WIDTH - NAMES + 20.0, HEIGHT - 14.0];
        svg.text(note, "both axes logarithmic", &format!(r#"fill="{MUTED}""#));
        svg.finish([WIDTH, HEIGHT], &self.title)
    }

    /// The powers of ten around all points, along or up.
    fn axis(&self, number: fn(Vector<f64>) -> f64) -> Axis {
        let points = self.lines.iter().flat_map(shown);
        let logs = Range::of(points.map(|point| number(point).log10()));
        if logs.size() < 0.0 {
            return Axis::logarithmic(Range::new(0.1, 1.0));
        }
        // Some room, so that no dot sits on the frame; at least a decade in all.
        let room = 0.05_f64.max(0.5 * (1.0 - logs.size()));
        Axis::logarithmic(logs.widened(room).map(|v| 10f64.powf(v)))
    }
}

/// The points of a line with two positive finite numbers.
fn shown(line: &Line) -> impl Iterator<Item = Vector<f64>> {
    let fits = |point: &Vector<f64>| point.iter().all(|v| v.is_finite() && *v > 0.0);
    line.points.iter().copied().filter(fits)
}

#[cfg(test)]
mod tests {
    use super::{Line, LogChart};
    use cosmic::geometry::Vector;

    #[test]
    fn points_that_no_logarithm_has_are_left_out() {
        let points = [[1e-3, 1e-9], [1e-2, 0.0], [0.1, f64::NAN], [1.0, 1e-3]];
        let chart = LogChart {
            name: "errors",
            caption: String::new(),
            title: "error, m".to_owned(),
            along: "time, s".to_owned(),
            lines: vec![Line::new(
                "a < b".to_owned(),
                0,
                "",
                points.into_iter().map(Vector::new),
            )],
            marked: Some((Vector::new([1.0, 1e-3]), "default".to_owned())),
        };
        let svg = chart.draw();
        assert_eq!(svg.matches("<circle").count(), 2 + 1);
        assert!(svg.contains("a &lt; b") && !svg.contains("NaN") && !svg.contains("inf"));
        let empty = LogChart {
            lines: Vec::new(),
            marked: None,
            ..chart
        };
        assert!(empty.draw().ends_with("</svg>\n"));
    }
}
