//! Axes and lines of a chart.

use super::svg::{BOLD, INK_LINE, MIDDLE, MUTED_END, MUTED_MIDDLE, RULE_LINE, Svg};

/// A chart's place in the drawing and the numbers it spans.
pub(super) struct Axes {
    /// Left and top edge, pixels.
    pub(super) origin: [f64; 2],
    /// Width and height, pixels.
    pub(super) size: [f64; 2],
    /// Least and largest number along.
    pub(super) x: [f64; 2],
    /// Least and largest number up.
    pub(super) y: [f64; 2],
    /// True for logarithmic axes, along and up. Their numbers must be positive.
    pub(super) log: [bool; 2],
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
    pub points: Vec<[f64; 2]>,
}

impl Line {
    /// A line in the `k`-th colour.
    pub fn new(
        name: String,
        k: usize,
        dashes: &'static str,
        points: impl Iterator<Item = [f64; 2]>,
    ) -> Self {
        Self {
            name,
            colour: COLOURS[k % COLOURS.len()],
            dashes,
            points: points.collect(),
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
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let scale = |v: f64| v.max(f64::MIN_POSITIVE).ln();
        let share = |v: f64, [from, to]: [f64; 2], log: bool| {
            let ends = [v, from, to];
            let [v, from, to] = if log { ends.map(scale) } else { ends };
            ((v - from) / (to - from)).clamp(0.0, 1.0)
        };
        let [left, top] = self.origin;
        [
            left + self.size[0] * share(x, self.x, self.log[0]),
            top + self.size[1] * (1.0 - share(y, self.y, self.log[1])),
        ]
    }

    /// Rulings and numbers at round values, the title above.
    pub(super) fn draw(&self, svg: &mut Svg, title: &str) {
        let [left, top] = self.origin;
        let [right, bottom] = [left + self.size[0], top + self.size[1]];
        for value in marks(self.y, self.log[1], 4) {
            let y = self.place([self.x[0], value])[1];
            svg.line([left, y], [right, y], RULE_LINE);
            svg.text([left - 8.0, y + 4.0], &number(value), MUTED_END);
        }
        svg.line([left, bottom], [right, bottom], INK_LINE);
        svg.text([left, top - 10.0], title, BOLD);
    }

    /// Numbers below the chart.
    pub(super) fn draw_along(&self, svg: &mut Svg, label: &str) {
        let [left, bottom] = [self.origin[0], self.origin[1] + self.size[1]];
        for value in marks(self.x, self.log[0], 8) {
            let x = self.place([value, self.y[0]])[0];
            svg.line([x, bottom], [x, bottom + 4.0], INK_LINE);
            svg.text([x, bottom + 18.0], &number(value), MUTED_MIDDLE);
        }
        let middle = [left + 0.5 * self.size[0], bottom + 36.0];
        svg.text(middle, label, MIDDLE);
    }

    /// Draws the lines, and their names right-aligned in the line of the title.
    pub(super) fn draw_lines(&self, svg: &mut Svg, lines: &[Line]) {
        let mut left = self.origin[0] + self.size[0];
        for Line { name, colour, .. } in lines.iter().rev() {
            let y = self.origin[1] - 10.0;
            // An average letter of 12 pixels is some 6 wide.
            left -= 6.4 * name.chars().count() as f64 + 12.0;
            svg.text([left, y], name, "");
            left -= 22.0;
            let key = format!(r#"stroke="{colour}" stroke-width="3""#);
            svg.line([left, y - 4.0], [left + 16.0, y - 4.0], &key);
        }
        for line in lines {
            for part in line.points.split(|[_, y]| !y.is_finite()) {
                let places: Vec<[f64; 2]> = part.iter().map(|&p| self.place(p)).collect();
                if !places.is_empty() {
                    svg.polyline(&places, &line.stroke());
                }
            }
        }
    }
}

/// The least and largest finite numbers, widened to contain `always`. The range has a width.
pub(super) fn range(numbers: impl Iterator<Item = f64>, always: [f64; 2]) -> [f64; 2] {
    let finite = numbers.filter(|v| v.is_finite());
    let [least, most] = finite.fold(always, |[a, b], v| [a.min(v), b.max(v)]);
    if least < most {
        [least, most]
    } else {
        [least - 0.5, most + 0.5]
    }
}

/// Round values in a range, or powers of ten.
fn marks(range: [f64; 2], log: bool, count: usize) -> Vec<f64> {
    if log {
        decades(range)
    } else {
        round_values(range, count)
    }
}

/// At most some `count` values in a range, at steps of 1, 2 or 5 times a power of ten.
fn round_values([from, to]: [f64; 2], count: usize) -> Vec<f64> {
    let least = (to - from) / count as f64;
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    // The last is above `least` but for rounding.
    let step = step.into_iter().find(|s| *s >= least).unwrap_or(step[3]);
    let [first, last] = [(from / step).ceil() as i64, (to / step).floor() as i64];
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Powers of ten in a range, at most some six.
fn decades([from, to]: [f64; 2]) -> Vec<f64> {
    let [first, last] = [from.log10().ceil() as i32, to.log10().floor() as i32];
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
    use super::{Axes, decades, number, range, round_values};

    #[test]
    fn marks_are_round_and_inside() {
        assert_eq!(
            round_values([0.0, 300.0], 8),
            [0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0]
        );
        assert_eq!(round_values([-0.9, 1.1], 4), [-0.5, 0.0, 0.5, 1.0]);
        assert_eq!(decades([0.02, 500.0]), [0.1, 1.0, 10.0, 100.0]);
        assert_eq!(
            [0.1 + 0.2, -2.0, 0.0, 1e-6, 12345.0].map(number),
            ["0.3", "\u{2212}2", "0", "1e-6", "12345"]
        );
    }

    #[test]
    fn a_range_has_width_and_ignores_what_is_not_finite() {
        let numbers = [1.0, f64::NAN, f64::INFINITY, 3.0].into_iter();
        assert_eq!(range(numbers, [2.0, 2.0]), [1.0, 3.0]);
        assert_eq!(range([].into_iter(), [2.0, 2.0]), [1.5, 2.5]);
    }

    #[test]
    fn points_are_placed_from_the_lower_left() {
        let axes = Axes {
            origin: [10.0, 20.0],
            size: [100.0, 50.0],
            x: [0.0, 4.0],
            y: [1.0, 100.0],
            log: [false, true],
        };
        let place = axes.place([2.0, 10.0]);
        // Quotients of logarithms, rounded at 1e-16, times 50 pixels.
        assert!((place[0] - 60.0).abs() < 1e-12 && (place[1] - 45.0).abs() < 1e-12);
        assert_eq!(axes.place([9.0, 0.0]), [110.0, 70.0]);
        let both = Axes {
            x: [1e-2, 1.0],
            log: [true; 2],
            ..axes
        };
        let place = both.place([0.1, 10.0]);
        assert!((place[0] - 60.0).abs() < 1e-12 && (place[1] - 45.0).abs() < 1e-12);
    }
}
