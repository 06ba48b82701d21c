//! Axes and lines of a chart.

use cosmic::geometry::{Range, Vector};

use super::picture::{Colour, Font, INK, Pen, Picture, Place, RULE};

/// The two axes of a chart. They know the place of the chart in the picture and the range of numbers that it shows.
pub struct Axes {
    /// The upper left corner.
    pub origin: Place,
    /// The width and the height.
    pub size: Place,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
}

/// One axis of a chart: the range of its numbers, and whether it is logarithmic.
#[derive(Clone, Copy)]
pub struct Axis {
    /// The numbers at the ends of the axis.
    pub range: Range,
    /// True for a logarithmic axis, whose numbers must be positive.
    pub log: bool,
}

impl Axis {
    /// A linear axis.
    pub fn linear(range: Range) -> Self {
        Self { range, log: false }
    }

    /// A logarithmic axis of positive numbers.
    pub fn logarithmic(range: Range) -> Self {
        Self { range, log: true }
    }

    /// Returns the position of a number on the axis: 0 at its beginning, 1 at its end.
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

    /// Returns the numbers to label: about `count` round numbers, or powers of ten on a logarithmic axis.
    fn marks(&self, count: usize) -> Vec<f64> {
        if self.log {
            decades(self.range)
        } else {
            round_values(self.range, count)
        }
    }
}

/// Colours that colour-blind readers can tell apart.
const COLOURS: [Colour; 8] = [
    Colour::hex(0x0b62b8),
    Colour::hex(0xd9541e),
    Colour::hex(0x2a8f5b),
    Colour::hex(0x8a4fb0),
    Colour::hex(0xb8860b),
    Colour::hex(0x1f2328),
    Colour::hex(0xc2185b),
    Colour::hex(0x00838f),
];

/// A named line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// The name in the legend.
    pub name: String,
    /// The colour.
    pub colour: Colour,
    /// The lengths of dashes and gaps in pixels, as SVG writes them; empty for a solid line.
    pub dashes: &'static str,
    /// The points. A point that is not finite makes a gap.
    pub points: Vec<Vector<f64>>,
}

impl Line {
    /// Creates a line with the `k`-th colour.
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

    pub(super) fn pen(&self) -> Pen {
        Pen::dashed(self.colour, 1.6, self.dashes)
    }
}

impl Axes {
    /// Returns the place of a point in the picture. A point outside the range of an axis is moved to the end of that
    /// axis.
    pub fn place(&self, point: Vector<f64>) -> Place {
        let [x, y] = point.array();
        Vector::new([self.across(x), self.down(y)])
    }

    /// Returns the place of a number on the horizontal axis, in pixels from the left.
    pub(super) fn across(&self, x: f64) -> f64 {
        self.origin[0] + self.size[0] * self.x.share(x)
    }

    /// Returns the place of a number on the vertical axis, in pixels from the top.
    pub(super) fn down(&self, y: f64) -> f64 {
        self.origin[1] + self.size[1] * (1.0 - self.y.share(y))
    }

    /// Draws the title and the vertical axis with its grid.
    pub(super) fn draw(&self, picture: &mut Picture, title: &str) {
        let [left, top] = self.origin.array();
        let [right, bottom] = (self.origin + self.size).array();
        for value in self.y.marks(4) {
            let y = self.down(value);
            picture.line([[left, y], [right, y]], Pen::new(RULE, 1.0));
            let font = Font::MUTED.at(1.0);
            picture.text([left - 8.0, y + 4.0], number(value), font);
        }
        picture.line([[left, bottom], [right, bottom]], Pen::new(INK, 1.0));
        picture.text([left, top - 10.0], title, Font::BOLD);
    }

    /// Draws the numbers and the label of the horizontal axis.
    pub(super) fn draw_along(&self, picture: &mut Picture, label: &str) {
        let [right, bottom] = (self.origin + self.size).array();
        for value in self.x.marks(8) {
            let x = self.across(value);
            picture.line([[x, bottom], [x, bottom + 4.0]], Pen::new(INK, 1.0));
            picture.text([x, bottom + 18.0], number(value), Font::CAPTION);
        }
        let middle = 0.5 * (self.origin[0] + right);
        picture.text([middle, bottom + 36.0], label, Font::MIDDLE);
    }
}

/// Returns a range that contains the range `always` and all finite `numbers`. The width of the result is not 0.
pub fn range(numbers: impl Iterator<Item = f64>, always: Range) -> Range {
    let range = numbers.filter(|v| v.is_finite()).fold(always, Range::with);
    if range.size() > 0.0 {
        range
    } else {
        range.widened(0.5)
    }
}

/// Returns about `count` values in a range, at steps of 1, 2 or 5 times a power of ten.
pub fn round_values(range: Range, count: usize) -> Vec<f64> {
    let Range { low, high } = range;
    let least = range.size() / count as f64;
    let power = 10f64.powf(least.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    // The last of the four steps is at least `least`, except for rounding.
    let step = step.into_iter().find(|s| *s >= least).unwrap_or(step[3]);
    let [first, last] = [(low / step).ceil() as i64, (high / step).floor() as i64];
    (first..=last).map(|k| k as f64 * step).collect()
}

/// Returns the powers of ten in a range. If there are more than six, returns only some of them.
pub fn decades(range: Range) -> Vec<f64> {
    let Range { low, high } = range;
    let [first, last] = [low.log10().ceil() as i32, high.log10().floor() as i32];
    let every = 1 + (last - first).max(0) / 5;
    let powers = (first..=last).step_by(every as usize);
    powers.map(|k| 10f64.powf(k.into())).collect()
}

/// Returns the text of a number on an axis.
pub fn number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e5).contains(&value.abs()) {
        return format!("{value:.0e}");
    }
    // The number is a multiple of a decimal step, so its last digits have rounding errors.
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.replace('-', "\u{2212}")
}
