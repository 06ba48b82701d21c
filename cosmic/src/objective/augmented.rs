//! The augmented Lagrangian, which keeps the binarisation measures below their thresholds.

use autodiff::Real;
use serde::{Deserialize, Serialize};

use super::Measures;

/// The amount by which each measure exceeds its threshold. The amount is zero, with derivative zero, for a measure that
/// does not exceed its threshold.
pub fn violations<R: Real>(measures: [R; 4], thresholds: &[f64; 4]) -> [R; 4] {
    [0, 1, 2, 3].map(|k| (measures[k] - R::lit(thresholds[k])).max(R::zero()))
}

/// The largest value that a penalty can reach. Larger penalties would make the terms of the objective overflow.
const LARGEST: f64 = 1e100;
/// The smallest value that a penalty can reach. A penalty of zero could never grow again.
const LEAST: f64 = 1e-100;

/// The multiplier and the penalty of each of the four measures, in the order of
/// [`Measures::constrained`](super::Measures::constrained).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AugmentedLagrangian {
    /// Multipliers (lambda).
    pub multiplier: [f64; 4],
    /// Penalties (tau).
    pub penalty: [f64; 4],
}

impl AugmentedLagrangian {
    /// The multipliers and penalties at the start of a run: all multipliers are zero, and all penalties are `penalty`.
    pub fn new(penalty: f64) -> Self {
        Self {
            multiplier: [0.0; 4],
            penalty: [penalty; 4],
        }
    }

    /// The augmented objective, `loss + sum_k (-lambda_k v_k + tau_k v_k^2 / 2)`. `v_k` are the `violations`.
    pub fn objective<R: Real>(&self, loss: R, violations: [R; 4]) -> R {
        (0..4).fold(loss, |objective, k| {
            let v = violations[k];
            let multiplier = R::lit(self.multiplier[k]);
            objective + v * (R::lit(0.5 * self.penalty[k]) * v - multiplier)
        })
    }

    /// The sum of the terms that the augmented objective adds to the loss, given the measures and their thresholds.
    pub fn terms<R: Real>(&self, measures: &Measures<R>, thresholds: &[f64; 4]) -> R {
        self.objective(R::zero(), violations(measures.constrained(), thresholds))
    }

    /// Updates the multipliers and penalties after an iteration. From each multiplier, its violation times its penalty
    /// is subtracted. Then each penalty is multiplied by `growth` if its violation grew since the previous iteration,
    /// and divided by `growth` if it fell.
    pub fn update(&mut self, violations: &[f64; 4], previous: &[f64; 4], growth: f64) {
        for k in 0..4 {
            self.multiplier[k] -= self.penalty[k] * violations[k];
            if violations[k] > previous[k] {
                self.penalty[k] = (self.penalty[k] * growth).min(LARGEST);
            } else if violations[k] < previous[k] {
                self.penalty[k] = (self.penalty[k] / growth).max(LEAST);
            }
        }
    }
}
