//! Axes and lines of a chart.

use cosmic::geometry::{Range, Vector};

use super::svg::{BOLD, INK_LINE, MIDDLE, MUTED_END, MUTED_MIDDLE, RULE_LINE, Svg};

/// A chart's place in the drawing and the numbers it spans.
pub(super) struct Axes {
    /// Left and top edge, pixels.
    pub(super) origin: Vector<f64>,
    /// Width and height, pixels.
    pub(super) size: Vector<f64>,
    /// Along.
    pub(super) x: Axis,
    /// Up.
    pub(super) y: Axis,
}

/// The numbers along an axis.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    /// From its beginning to its end.
    pub(super) range: Range,
    /// True for a logarithmic axis. Its numbers must be positive.
    pub(super) log: bool,
}

impl Axis {
    /// An axis in equal steps.
    pub(super) fn linear(range: Range) -> Self {
        Self { range, log: false }
    }

    /// An axis in equal factors.
    pub(super) fn logarithmic(range: Range) -> Self {
        Self { range, log: true }
    }

    /// How far along the axis a number is, from 0 to 1.
    fn share(&self, number: f64) -> f64 {
        let scale = |v: f64| {
            if self.log {
                v.max(f64::MIN_POSITIVE).ln()
            } else {
                v
            }
        };
        let range = self.range.map(scale);
        ((scale(number) - range.low) / range.size()).clamp(0.0, 1.0)
    }

    /// Round numbers, or powers of ten.
    fn marks(&self, count: usize) -> Vec<f64> {
        if self.log {
            decades(self.range)
        } else {
            round_values(self.range, count)
        }
    }
}

/// Colours that colour-blind readers can tell apart.
const COLOURS: [&str; 8] = [
    "#0b62b8", "#d9541e", "#2a8f5b", "#8a4fb0", "#b8860b", "#1f2328", "#c2185b", "#00838f",
];

/// A named line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its name.
    pub name: String,
    /// As in CSS.
    pub colour: &'static str,
    /// The pattern of its dashes as in SVG; empty for a whole line.
    pub dashes: &'static str,
    /// The points of the line. A point that is not finite makes a gap.
    pub points: Vec<Vector<f64>>,
}

impl Line {
    /// A line in the `k`-th colour.
    pub fn new(
        name: String,
        k: usize,
        dashes: &'static str,
        points: impl Iterator<Item = impl Into<Vector<f64>>>,
    ) -> Self {
        Self {
            name,
            colour: COLOURS[k % COLOURS.len()],
            dashes,
            points: points.map(Into::into).collect(),
        }
    }

    /// The style of the line.
    pub(super) fn stroke(&self) -> String {
        let Self { colour, dashes, .. } = self;
        format!(
            r#"stroke="{colour}" stroke-width="1.6" stroke-linejoin="round" stroke-linecap="round" stroke-dasharray="{dashes}""#
        )
    }
}

impl Axes {
    /// The place of a point in the drawing. A point beyond the range is drawn at its end.
    pub(super) fn place(&self, point: Vector<f64>) -> Vector<f64> {
        let [x, y] = point.array();
        Vector::new([self.across(x), self.down(y)])
    }

    /// How far from the left of the drawing a number along is.
    pub(super) fn across(&self, x: f64) -> f64 {
        let ([left, _], [width, _]) = (self.origin.array(), self.size.array());
        left + width * self.x.share(x)
    }

    /// How far from the top of the drawing a number up is.
    pub(super) fn down(&self, y: f64) -> f64 {
        let ([_, top], [_, height]) = (self.origin.array(), self.size.array());
        top + height * (1.0 - self.y.share(y))
    }

    /// Rulings and numbers at round values, the title above.
    pub(super) fn draw(&self, svg: &mut Svg, title: &str) {
        let [left, top] = self.origin.array();
        let [right, bottom] = (self.origin + self.size).array();
        for value in self.y.marks(4) {
            let y = self.down(value);
            svg.line([left, y], [right, y], RULE_LINE);
            svg.text([left - 8.0, y + 4.0], &number(value), MUTED_END);
        }
        svg.line([left, bottom], [right, bottom], INK_LINE);
        svg.text([left, top - 10.0], title, BOLD);
    }

    /// Numbers below the chart.
    pub(super) fn draw_along(&self, svg: &mut Svg, label: &str) {
        let [right, bottom] = (self.origin + self.size).array();
        for value in self.x.marks(8) {
            let x = self.across(value);
            svg.line([x, bottom], [x, bottom + 4.0], INK_LINE);
            svg.text([x, bottom + 18.0], &number(value), MUTED_MIDDLE);
        }
        let middle = 0.5 * (self.origin.forward() + right);
        svg.text([middle, bottom + 36.0], label, MIDDLE);
    }

    /// Draws the lines, and their names right-aligned in the line of the title.
    pub(super) fn draw_lines(&self, svg: &mut Svg, lines: &[Line]) {
        let mut left = (self.origin + self.size).forward();
        for Line { name, colour, .. } in lines.iter().rev() {
            let y = self.origin.up() - 10.0;
            // An average letter of 12 pixels is some 6 wide.
            left -= 6.4 * name.chars().count() as f64 + 12.0;
            svg.text([left, y], name, "");
            left -= 22.0;
            let key = format!(r#"stroke="{colour}" stroke-width="3""#);
            svg.line([left, y - 4.0], [left + 16.0, y - 4.0], &key);
        }
        for line in lines {
            for part in line.points.split(|point| !point.up().is_finite()) {
                let places: Vec<Vector<f64>> = part.iter().map(|&p| self.place(p)).collect();
                if !places.is_empty() {
                    svg.polyline(&places, &line.stroke());
                }
            }
        }
    }
}

/// The least and largest finite numbers, widened to contain `always`. The range has a width.
pub(super) fn range(numbers: impl Iterator<Item = f64>, always: Range) -> Range {
    let range = numbers.filter(|v| v.is_finite()).fold(always, Range::with);
    if range.size() > 0.0 {
        range
    } else {
        range.widened(0.5)
    }
}

/// At most some `count` values in a range, at steps of 1, 2 or 5 times a power of ten.
fn round_values(range: Range, count: usize) -> Vec<f64> {
    let Range { low, high } = range;
    let least = range.size() / count as f64;
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    // The last is above `least` but for rounding.
    let step = step.into_iter().find(|s| *s >= least).unwrap_or(step[3]);
    let [first, last] = [(low / step).ceil() as i64, (high / step).floor() as i64];
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Powers of ten in a range, at most some six.
fn decades(range: Range) -> Vec<f64> {
    let Range { low, high } = range;
    let [first, last] = [low.log10().ceil() as i32, high.log10().floor() as i32];
    let every = 1 + (last - first).max(0) / 5;
    let powers = (first..=last).step_by(every as usize);
    powers.map(|k| 10f64.powf(k.into())).collect()
}

/// The shortest text of a number for axes.
fn number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.0e}");
    }
    // Multiples of a decimal step carry rounding errors in their last places.
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::{Axes, Axis, decades, number, range, round_values};
    use cosmic::geometry::{Range, Vector};

    #[test]
    fn marks_are_round_and_inside() {
        assert_eq!(
            round_values(Range::new(0.0, 300.0), 8),
            [0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0]
        );
        assert_eq!(
            round_values(Range::new(-0.9, 1.1), 4),
            [-0.5, 0.0, 0.5, 1.0]
        );
        assert_eq!(decades(Range::new(0.02, 500.0)), [0.1, 1.0, 10.0, 100.0]);
        assert_eq!(
            [0.1 + 0.2, -2.0, 0.0, 1e-6, 12345.0].map(number),
            ["0.3", "\u{2212}2", "0", "1e-6", "12345"]
        );
    }

    #[test]
    fn a_range_has_width_and_ignores_what_is_not_finite() {
        let numbers = [1.0, f64::NAN, f64::INFINITY, 3.0].into_iter();
        let two = Range::new(2.0, 2.0);
        assert_eq!(range(numbers, two), Range::new(1.0, 3.0));
        assert_eq!(range([].into_iter(), two), Range::new(1.5, 2.5));
    }

    #[test]
    fn points_are_placed_from_the_lower_left() {
        let axes = Axes {
            origin: Vector::new([10.0, 20.0]),
            size: Vector::new([100.0, 50.0]),
            x: Axis::linear(Range::new(0.0, 4.0)),
            y: Axis::logarithmic(Range::new(1.0, 100.0)),
        };
        let middle = Vector::new([60.0, 45.0]);
        // Quotients of logarithms, rounded at 1e-16, times 50 pixels.
        assert!(axes.place(Vector::new([2.0, 10.0])).distance(middle) < 1e-12);
        assert_eq!(axes.place(Vector::new([9.0, 0.0])), [110.0, 70.0]);
        let both = Axes {
            x: Axis::logarithmic(Range::new(1e-2, 1.0)),
            ..axes
        };
        assert!(both.place(Vector::new([0.1, 10.0])).distance(middle) < 1e-12);
    }
}
