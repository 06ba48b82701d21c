//! A setting in place, and the range allowed for its number.

use super::value::SettingValue;
use std::fmt;

/// A setting in place, with all that its declaration says of it.
pub(super) struct Field<'a> {
    pub(super) key: &'static str,
    /// What it means, in sentences.
    pub(super) doc: &'static str,
    /// The unit; empty for a pure number, a name or a truth value.
    pub(super) unit: &'static str,
    /// Where the default comes from: the paper, a decision (D1 to D11), an experiment.
    pub(super) source: &'static str,
    pub(super) limits: Limits,
    pub(super) value: &'a mut dyn SettingValue,
}

impl Field<'_> {
    /// What may stand at the key, as a phrase.
    pub(super) fn allowed(&self) -> String {
        self.value.allowed(&self.limits)
    }
}

/// A section of a scene file; [`settings`](super::settings) declares it.
pub(super) trait Settings {
    /// What the section is about, in a sentence.
    fn about(&self) -> &'static str;
    /// Its settings, in the order in which they are written.
    fn fields(&mut self) -> Vec<Field<'_>>;
}

/// The finite numbers allowed: for arrays each entry, for a cycle its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limits {
    low: f64,
    high: f64,
    low_included: bool,
}

impl Limits {
    /// For values that are no numbers.
    pub(super) const NONE: Limits = within(f64::MIN, f64::MAX);

    /// False for NaN and infinities too.
    pub(super) fn contain(&self, x: f64) -> bool {
        x <= self.high && (x > self.low || self.low_included && x == self.low)
    }
}

/// From `low` to `high`, both allowed.
pub(super) const fn within(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: true,
    }
}

/// Above `low`, up to `high`.
pub(super) const fn above(low: f64, high: f64) -> Limits {
    Limits {
        low,
        high,
        low_included: false,
    }
}

/// Numbers of an iteration; 0 is before the first one.
pub(super) const ITERATIONS: Limits = within(0.0, 1e5);
/// Lengths of rollouts and of parts of them.
pub(super) const STEPS: Limits = within(1.0, 1e6);
/// Factors and costs that have no natural bound.
pub(super) const POSITIVE: Limits = above(0.0, 1e6);
/// Shares of a whole.
pub(super) const SHARE: Limits = within(0.0, 1.0);
/// Shares by which a positive number is off and stays positive.
pub(super) const DEVIATION: Limits = within(0.0, 0.99);

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
