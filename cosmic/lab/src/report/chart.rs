//! Charts with two logarithmic axes, such as errors against costs.

use cosmic::geometry::{Range, Vector};

use super::picture::{Font, INK, PAPER, Pen, Picture};
use super::plot::{Axes, Axis};

pub use super::plot::Line;

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 440.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 50.0;
/// The width of the legend, in pixels.
const NAMES: f64 = 270.0;

/// A chart with two logarithmic axes, which becomes a file `name.svg`.
#[derive(Clone, Debug, PartialEq)]
pub struct LogChart {
    /// The name of the file, without `.svg`.
    pub name: String,
    /// The caption.
    pub caption: String,
    /// The heading: the quantity of the vertical axis, with its unit.
    pub title: String,
    /// The quantity of the horizontal axis, with its unit.
    pub along: String,
    /// The lines.
    pub lines: Vec<Line>,
    /// A point of the chart to mark with a ring, and the name of the point.
    pub marked: Option<(Vector<f64>, String)>,
}

impl LogChart {
    /// Draws the chart as SVG.
    pub fn draw(&self) -> String {
        let axes = Axes {
            origin: Vector::new([LEFT, TOP]),
            size: Vector::new([WIDTH - LEFT - NAMES, HEIGHT - TOP - 50.0]),
            x: self.axis(Vector::forward),
            y: self.axis(Vector::up),
        };
        let mut picture = Picture::default();
        axes.draw(&mut picture, &self.title);
        axes.draw_along(&mut picture, &self.along);
        for (k, line) in self.lines.iter().enumerate() {
            let places = shown(line).map(|p| axes.place(p));
            picture.line(places.clone(), line.pen());
            places.for_each(|place| picture.dot(place, 2.6, line.colour));
            let [x, y] = [WIDTH - NAMES + 20.0, TOP + 8.0 + 19.0 * k as f64];
            picture.line([[x, y - 4.0], [x + 26.0, y - 4.0]], line.pen());
            picture.text([x + 34.0, y], &line.name[..], Font::PLAIN);
        }
        if let Some((point, name)) = &self.marked {
            let place = axes.place(*point);
            picture.disc(place, 8.0, PAPER.faint(0.0), Pen::new(INK, 1.6));
            picture.text(place + Vector::new([12.0, -10.0]), &name[..], Font::BOLD);
        }
        let note = [WIDTH - NAMES + 20.0, HEIGHT - 14.0];
        picture.text(note, "both axes logarithmic", Font::MUTED);
        picture.to_svg([WIDTH, HEIGHT], &self.title)
    }

    /// Returns an axis that has room for all points. `number` returns one coordinate of a point.
    fn axis(&self, number: fn(Vector<f64>) -> f64) -> Axis {
        let points = self.lines.iter().flat_map(shown);
        let logs = Range::of(points.map(|point| number(point).log10()));
        if logs.size() < 0.0 {
            return Axis::logarithmic(Range::new(0.1, 1.0));
        }
        // The margin keeps all dots off the frame. The axis spans at least a decade.
        let room = 0.05_f64.max(0.5 * (1.0 - logs.size()));
        Axis::logarithmic(logs.widened(room).map(|v| 10f64.powf(v)))
    }
}

/// Returns the points of a line that can be drawn on logarithmic axes: points with positive and finite coordinates.
fn shown(line: &Line) -> impl Iterator<Item = Vector<f64>> + Clone {
    let fits = |point: &Vector<f64>| point.iter().all(|v| v.is_finite() && *v > 0.0);
    line.points.iter().copied().filter(fits)
}
