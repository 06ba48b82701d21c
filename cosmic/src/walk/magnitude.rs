//! The magnitude of a quantity in the states of a rollout.

use serde::{Deserialize, Serialize};

/// The magnitude of a quantity over several states: its largest absolute value and a quantile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Magnitude {
    /// The largest absolute value.
    pub peak: f64,
    /// The 99 % quantile of the absolute values.
    pub p99: f64,
}

/// Collects the largest 1 % of the absolute values in a series, which determine its 99 % quantile.
#[derive(Clone, Debug)]
pub struct Largest {
    /// The number of largest values that determine the quantile.
    needed: usize,
    /// The `needed` largest values, unsorted, and fewer than `needed` other values.
    pub values: Vec<f64>,
    /// The smallest value that is still needed: smaller new values are ignored.
    floor: f64,
}

impl Largest {
    /// Prepares to collect from a series of `count` numbers.
    pub fn of(count: usize) -> Self {
        let below = 0.99 * count.saturating_sub(1) as f64;
        Self {
            needed: (count - below.round() as usize).max(1),
            values: Vec::new(),
            floor: 0.0,
        }
    }

    /// Adds a number of the series.
    pub fn see(&mut self, x: f64) {
        let x = x.abs();
        if self.values.len() >= self.needed && x <= self.floor {
            return;
        }
        self.values.push(x);
        if self.values.len() == 2 * self.needed {
            self.keep_needed();
        }
    }

    /// Sorts the values, largest first, and drops values that are not needed.
    fn keep_needed(&mut self) {
        self.values.sort_unstable_by(|a, b| b.total_cmp(a));
        self.values.truncate(self.needed);
        self.floor = self.values.last().copied().unwrap_or(0.0);
    }

    /// The largest value and the quantile of the numbers seen.
    pub fn magnitude(mut self) -> Magnitude {
        self.keep_needed();
        Magnitude {
            peak: self.values.first().copied().unwrap_or(0.0),
            p99: self.floor,
        }
    }
}

impl Magnitude {
    /// Combines two magnitudes: the larger of the two peaks, and the larger of the two quantiles.
    pub(super) fn max(self, other: Self) -> Self {
        Self {
            peak: self.peak.max(other.peak),
            p99: self.p99.max(other.p99),
        }
    }
}
