//! The allowed range of the numbers of a setting.

use std::fmt;

/// A range of finite numbers. For an array it limits every entry, for a cycle its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    low: f64,
    high: f64,
    low_included: bool,
}

impl Limits {
    /// No limits. Settings that are not numbers have these.
    pub const NONE: Limits = within(f64::MIN, f64::MAX);

    /// Whether a number is in the range. False for NaN and infinities.
    pub fn contain(&self, x: f64) -> bool {
        x <= self.high && (x > self.low || self.low_included && x == self.low)
    }
}

/// From `low` to `high`, both included.
pub const fn within(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: true,
    }
}

/// Above `low`, up to `high`, which is included.
pub const fn above(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: false,
    }
}

/// Numbers of iterations; 0 is before the first iteration.
pub(crate) const ITERATIONS: Limits = within(0.0, 1e5);
/// Lengths of a rollout or of a part of it, in steps.
pub(crate) const STEPS: Limits = within(1.0, 1e6);
/// Factors and costs without a natural bound.
pub(crate) const POSITIVE: Limits = above(0.0, 1e6);
/// Shares of a whole.
pub(crate) const SHARE: Limits = within(0.0, 1.0);
/// Relative deviations that keep a positive number positive.
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

/// A bound as people write it: `64`, not `64.0`; `1e9`, not `1000000000`.
fn plain(bound: f64) -> String {
    let text = if bound.abs() >= 1e5 {
        format!("{bound:e}")
    } else {
        format!("{bound:?}")
    };
    text.strip_suffix(".0").unwrap_or(&text).to_owned()
}
