//! A chart with a bar for each experiment, and the samples as points.

use super::picture::{Colour, Font, MUTED, Pen, Picture};
use super::plot::{Axes, Axis, range};
use crate::table::decimals;
use cosmic::geometry::{Range, Vector};

const WIDTH: f64 = 960.0;
/// The smallest distance of the bars from the left edge, in pixels. Longer names move the bars to the right.
const LEFT: f64 = 250.0;
/// The width of a letter of the names, in pixels.
const LETTER: f64 = 6.5;
const TOP: f64 = 56.0;
/// The height of a bar including the space around it, in pixels.
const ROW: f64 = 30.0;

/// A bar of the chart, which stands for one experiment. Numbers that are not finite are not drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bar {
    /// The name of the experiment.
    pub name: String,
    /// The length of the bar.
    pub value: Option<f64>,
    /// The numbers of the single runs from which `value` was computed. They are drawn as points.
    pub points: Vec<f64>,
    /// A number to compare the bar with, such as a published one. It is drawn as a tall stroke.
    pub mark: Option<f64>,
}

/// Draws horizontal bars as SVG, the first on top.
pub fn bars(title: &str, unit: &str, bars: &[Bar]) -> String {
    let height = ROW * bars.len() as f64;
    let numbers = bars.iter().flat_map(|bar| {
        let single = [bar.value, bar.mark].into_iter().flatten();
        single.chain(bar.points.iter().copied())
    });
    let range = range(numbers, Range::default());
    let letters = bars.iter().map(|bar| bar.name.chars().count()).max();
    let left = LEFT.max(24.0 + LETTER * letters.unwrap_or(0) as f64);
    let width = WIDTH.max(left + 0.5 * WIDTH);
    let axes = Axes {
        origin: Vector::new([left, TOP]),
        size: Vector::new([width - left - 40.0, height]),
        x: Axis::linear(range.with(range.high + 0.04 * range.size())),
        y: Axis::linear(Range::new(0.0, 1.0)),
    };
    let mut picture = Picture::default();
    picture.text([24.0, 28.0], title, Font::BOLD);
    let across = |x: f64| axes.across(x);
    let zero = across(0.0);
    for (k, bar) in bars.iter().enumerate() {
        let middle = TOP + ROW * (k as f64 + 0.5);
        picture.text([left - 12.0, middle + 4.0], &bar.name[..], Font::END);
        draw(&mut picture, bar, middle, &across);
    }
    picture.line([[zero, TOP], [zero, TOP + height]], Pen::new(MUTED, 1.0));
    axes.draw_along(&mut picture, unit);
    picture.to_svg([width, TOP + height + 56.0], title)
}

/// Draws one bar of the chart with its points and its mark.
fn draw(picture: &mut Picture, bar: &Bar, middle: f64, across: &dyn Fn(f64) -> f64) {
    let zero = across(0.0);
    if let Some(value) = bar.value.filter(|value| value.is_finite()) {
        let end = across(value);
        let size = [(end - zero).abs(), 16.0];
        picture.rectangle([zero.min(end), middle - 8.0], size, Colour::hex(0x9fc0e4));
        let place = [end.max(zero) + 6.0, middle + 4.0];
        picture.text(place, decimals(value, 2), Font::BOLD);
    }
    for &point in bar.points.iter().filter(|point| point.is_finite()) {
        picture.dot(
            [across(point), middle],
            2.6,
            Colour::hex(0x0b62b8).faint(0.45),
        );
    }
    if let Some(mark) = bar.mark.filter(|mark| mark.is_finite()) {
        let x = across(mark);
        let pen = Pen::new(Colour::hex(0xd9541e), 2.5);
        picture.line([[x, middle - 12.0], [x, middle + 12.0]], pen);
    }
}
