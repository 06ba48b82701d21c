//! The range of numbers that a setting allows.

use std::fmt;

/// A range of finite numbers. For an array, it is the range of every entry. For a cycle, it is the range of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    low: f64,
    high: f64,
    low_included: bool,
}

impl Limits {
    /// The range of all finite numbers, for settings without limits and for settings that are not numbers.
    pub const NONE: Limits = within(f64::MIN, f64::MAX);

    /// True if a number is in the range. NaN and infinities never are.
    pub fn contain(&self, x: f64) -> bool {
        x <= self.high && (x > self.low || self.low_included && x == self.low)
    }
}

/// The range from `low` to `high`. Both are included.
pub const fn within(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: true,
    }
}

/// The range from `low`, which is excluded, to `high`, which is included.
pub const fn above(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: false,
    }
}

/// The range of an iteration's number. 0 is before the first iteration.
pub(crate) const ITERATIONS: Limits = within(0.0, 1e5);
/// The range of the length of a rollout, or of a part of it, in steps.
pub(crate) const STEPS: Limits = within(1.0, 1e6);
/// The range of factors and costs without a natural bound.
pub(crate) const POSITIVE: Limits = above(0.0, 1e6);
/// The range of a share of a whole.
pub(crate) const SHARE: Limits = within(0.0, 1.0);
/// The range of a relative deviation. Within it, a deviation keeps a positive number positive.
pub(crate) const DEVIATION: Limits = within(0.0, 0.99);

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [low, high] = [self.low, self.high].map(plain);
        if self.low_included {
            write!(f, "from {low} to {high}")
        } else {
            write!(f, "above {low} and at most {high}")
        }
    }
}

/// Writes a bound as people do: `64` and not `64.0`, `1e9` and not `1000000000`.
fn plain(bound: f64) -> String {
    let text = if bound.abs() >= 1e5 {
        format!("{bound:e}")
    } else {
        format!("{bound:?}")
    };
    text.strip_suffix(".0").unwrap_or(&text).to_owned()
}
