//! Ranges of numbers.

use serde::{Deserialize, Serialize};

/// The range of numbers from `low` to `high`. In files it is an array, `[low, high]`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct Range {
    /// The least number.
    pub low: f64,
    /// The greatest number.
    pub high: f64,
}

impl Range {
    /// The range between two numbers.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// The smallest range that contains all given numbers; from infinity to minus infinity if there are none.
    pub fn of(numbers: impl IntoIterator<Item = f64>) -> Self {
        let none = Self::new(f64::INFINITY, f64::NEG_INFINITY);
        numbers.into_iter().fold(none, Self::with)
    }

    /// The smallest range that contains this range and a number.
    #[must_use]
    pub fn with(self, number: f64) -> Self {
        Self::new(self.low.min(number), self.high.max(number))
    }

    /// True if a number is in the range.
    pub fn contains(&self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }

    /// The range with both ends moved outwards by a distance.
    #[must_use]
    pub fn widened(self, by: f64) -> Self {
        Self::new(self.low - by, self.high + by)
    }

    /// The length of the range.
    pub fn size(&self) -> f64 {
        self.high - self.low
    }

    /// Applies a function to both ends of the range.
    #[must_use]
    pub fn map(self, of: impl Fn(f64) -> f64) -> Self {
        Self::new(of(self.low), of(self.high))
    }
}

impl From<[f64; 2]> for Range {
    fn from([low, high]: [f64; 2]) -> Self {
        Self { low, high }
    }
}

impl From<Range> for [f64; 2] {
    fn from(range: Range) -> Self {
        [range.low, range.high]
    }
}
