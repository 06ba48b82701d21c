//! The section of a run's page that shows the robot's ways to several goals.

use super::motion::strained;
use super::picture::{Font, Pen, Picture};
use super::plot::{Axes, Axis, number, range};
use crate::walk::{Leg, Way, table};
use cosmic::geometry::{Range, Vector};

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 420.0;
const LEFT: f64 = 64.0;
const TOP: f64 = 40.0;
/// The space to the right of the chart, for the names of the goals.
const RIGHT: f64 = 70.0;

/// Returns the section; empty if there are no ways.
pub(super) fn section(ways: &[Way]) -> String {
    if ways.is_empty() {
        return String::new();
    }
    let legs: Vec<Leg> = ways.iter().map(|way| way.leg).collect();
    format!(
        include_str!("page/ways.html"),
        chart = draw(ways),
        table = table(&legs).to_html()
    )
}

/// Draws the position along the ground over time, as a line for each way. Goals behind the robot are blue, goals ahead
/// are red.
fn draw(ways: &[Way]) -> String {
    let goals = ways.iter().map(|way| way.leg.goal);
    let farthest = goals
        .clone()
        .fold(0.0, |most: f64, goal| most.max(goal.abs()));
    let places = ways.iter().flat_map(|way| &way.path).map(|point| point[1]);
    let axes = Axes {
        origin: Vector::new([LEFT, TOP]),
        size: Vector::new([WIDTH - LEFT - RIGHT, HEIGHT - TOP - 50.0]),
        x: Axis::linear(Range::new(0.0, ways[0].leg.until)),
        y: Axis::linear(range(places.chain(goals), Range::new(0.0, 0.0))),
    };
    let mut picture = Picture::default();
    axes.draw(&mut picture, "Position along the ground, m");
    axes.draw_along(&mut picture, "time, s");
    for Way { leg, path } in ways {
        let colour = strained(leg.goal / farthest.max(f64::MIN_POSITIVE));
        let ends = [leg.from, leg.until].map(|time| axes.place(Vector::new([time, leg.goal])));
        picture.line(ends, Pen::dashed(colour, 1.2, "4 4"));
        let name = ends[1] + Vector::new([8.0, 4.0]);
        picture.text(name, number(leg.goal) + " m", Font::MUTED);
        let path = path.iter().map(|&point| axes.place(Vector::new(point)));
        picture.line(path, Pen::new(colour, 1.8));
    }
    let title = "Position along the ground over time, for each goal";
    picture.to_svg([WIDTH, HEIGHT], title)
}
