//! The augmented Lagrangian: inequality violations enter the objective with multipliers and
//! penalties that follow them.
//!
//! A violation `v_k = max(0, g_k - g_k*)` adds `-lambda_k v_k + tau_k v_k^2 / 2` to the objective,
//! with multiplier `lambda_k` (at most 0, the sign is the paper's) and penalty `tau_k`.

use autodiff::Real;
use serde::{Deserialize, Serialize};

use super::error::{OptimiserError, check, check_length};

/// The settings that stay for a whole run.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AugmentedLagrangian {
    /// Every penalty at the start.
    pub penalty: f64,
    /// Factor on the penalty where a violation grew; where it fell, one over it.
    pub penalty_growth: f64,
}

impl Default for AugmentedLagrangian {
    fn default() -> Self {
        AugmentedLagrangian {
            penalty: 0.3,
            penalty_growth: 1.01,
        }
    }
}

/// Multipliers and penalties, with the violations they were last updated for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AugmentedState {
    /// One multiplier a violation; 0 at the start.
    pub multipliers: Vec<f64>,
    /// One penalty a violation.
    pub penalties: Vec<f64>,
    /// The violations of the last update; none before the first.
    pub violations: Option<Vec<f64>>,
}

impl AugmentedLagrangian {
    /// The state before the first update, for `count` violations.
    #[must_use]
    pub fn init(&self, count: usize) -> AugmentedState {
        AugmentedState {
            multipliers: vec![0.0; count],
            penalties: vec![self.penalty; count],
            violations: None,
        }
    }

    /// Moves the multipliers by the old penalties, then the penalties by how the violations changed
    /// since the last update (in the first they do not move).
    ///
    /// # Errors
    /// Slices of the wrong length, or a violation that is not finite. The state is then unchanged.
    pub fn update(
        &self,
        state: &mut AugmentedState,
        violations: &[f64],
    ) -> Result<(), OptimiserError> {
        check("violations", violations, state.multipliers.len())?;
        check_length("state: penalties", &state.penalties, violations.len())?;
        let before = state.violations.as_deref().unwrap_or(violations);
        check_length("state: violations", before, violations.len())?;
        for (k, &violation) in violations.iter().enumerate() {
            let penalty = &mut state.penalties[k];
            state.multipliers[k] -= *penalty * violation;
            if violation > before[k] {
                *penalty *= self.penalty_growth;
            } else if violation < before[k] {
                *penalty /= self.penalty_growth;
            }
        }
        state.violations = Some(violations.to_vec());
        Ok(())
    }
}

impl AugmentedState {
    /// What the violations add to the objective: `sum_k (-lambda_k v_k + tau_k v_k^2 / 2)`.
    ///
    /// # Panics
    /// If there are not as many violations as multipliers.
    pub fn terms<R: Real>(&self, violations: &[R]) -> R {
        assert_eq!(
            violations.len(),
            self.multipliers.len(),
            "terms: a violation for each multiplier"
        );
        let term = |k: usize| {
            let half_penalty = R::lit(0.5 * self.penalties[k]);
            violations[k] * (half_penalty * violations[k] - R::lit(self.multipliers[k]))
        };
        (0..violations.len()).fold(R::zero(), |sum, k| sum + term(k))
    }
}

#[cfg(test)]
mod tests {
    use autodiff::gradient_of;

    use super::AugmentedLagrangian;

    #[test]
    fn multipliers_move_by_the_old_penalties() {
        let method = AugmentedLagrangian {
            penalty: 0.5,
            penalty_growth: 2.0,
        };
        let mut state = method.init(3);
        method.update(&mut state, &[1.0, 1.0, 1.0]).unwrap();
        assert_eq!(state.multipliers, [-0.5, -0.5, -0.5]);
        assert_eq!(state.penalties, [0.5, 0.5, 0.5], "nothing to compare with");
        // Grew, fell, stayed.
        method.update(&mut state, &[3.0, 0.5, 1.0]).unwrap();
        assert_eq!(state.multipliers, [-2.0, -0.75, -1.0]);
        assert_eq!(state.penalties, [1.0, 0.25, 0.5]);
    }

    #[test]
    fn terms_pull_towards_smaller_violations() {
        let method = AugmentedLagrangian::default();
        let mut state = method.init(2);
        state.multipliers = vec![-2.0, 0.0];
        // 2 * 0.5 + 0.3 * 0.25 / 2 and 0.3 * 4 / 2, a rounding or two apart.
        assert!((state.terms(&[0.5, 2.0]) - 1.6375_f64).abs() < 1e-15);
        let slopes = gradient_of(|v| state.terms(v), &[0.5, 2.0]);
        assert!(slopes.iter().all(|&slope| slope > 0.0), "{slopes:?}");
        assert_eq!(state.terms(&[0.0, 0.0]), 0.0);
    }

    #[test]
    fn bad_violations_change_nothing() {
        let method = AugmentedLagrangian::default();
        let mut state = method.init(2);
        assert!(method.update(&mut state, &[0.0, f64::NAN]).is_err());
        assert!(method.update(&mut state, &[0.0]).is_err());
        assert_eq!(state, method.init(2));
    }
}
