//! Adam: steps of an adapted length along a decaying mean of the gradient.
//!
//! D. P. Kingma and J. Ba, "Adam: a method for stochastic optimization", ICLR 2015, algorithm 1.

use serde::{Deserialize, Serialize};

use super::error::{OptimiserError, check, check_length};

/// The settings that stay for a whole run; the learning rate is given to each update.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adam {
    /// Decay of the mean of the gradient, in `[0, 1)`.
    pub beta1: f64,
    /// Decay of the mean of the squared gradient, in `[0, 1)`.
    pub beta2: f64,
    /// Added to the root of the second mean, in units of the gradient.
    pub epsilon: f64,
}

impl Default for Adam {
    /// The paper's values.
    fn default() -> Self {
        Adam {
            beta1: 0.9,
            beta2: 0.999,
            epsilon: 1e-8,
        }
    }
}

/// What Adam remembers between updates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AdamState {
    /// Updates made so far.
    pub updates: u64,
    /// Decaying mean of the gradient, not corrected for its start at 0.
    pub mean: Vec<f64>,
    /// Decaying mean of the squared gradient, not corrected either.
    pub mean_square: Vec<f64>,
}

impl Adam {
    /// The state before the first update of `count` variables.
    #[must_use]
    pub fn init(&self, count: usize) -> AdamState {
        AdamState {
            updates: 0,
            mean: vec![0.0; count],
            mean_square: vec![0.0; count],
        }
    }

    /// Moves `variables` against the gradient; no variable moves by much more than `rate`.
    ///
    /// # Errors
    /// Slices of the wrong length, or a gradient that is not finite: state and variables are then
    /// unchanged.
    pub fn update(
        &self,
        state: &mut AdamState,
        variables: &mut [f64],
        gradient: &[f64],
        rate: f64,
    ) -> Result<(), OptimiserError> {
        let count = variables.len();
        check_length("state: mean of the gradient", &state.mean, count)?;
        check_length("state: mean of its square", &state.mean_square, count)?;
        check("gradient", gradient, count)?;
        state.updates += 1;
        let correct1 = bias_correction(self.beta1, state.updates);
        let correct2 = bias_correction(self.beta2, state.updates);
        for (j, &slope) in gradient.iter().enumerate() {
            let (mean, square) = (&mut state.mean[j], &mut state.mean_square[j]);
            *mean = self.beta1 * *mean + (1.0 - self.beta1) * slope;
            *square = self.beta2 * *square + (1.0 - self.beta2) * slope * slope;
            let step = *mean / correct1 / ((*square / correct2).sqrt() + self.epsilon);
            variables[j] -= rate * step;
        }
        Ok(())
    }
}

/// The share of a decaying mean that its entries make up, the rest being its start at 0.
fn bias_correction(decay: f64, updates: u64) -> f64 {
    // An integer power is a product, the same bits on every machine.
    1.0 - decay.powi(i32::try_from(updates).unwrap_or(i32::MAX))
}

/// Scales a vector down to the Euclidean norm `bound` if it is longer; returns the norm before.
///
/// A vector with an entry that is not finite is left alone: the norm returned is then not finite.
pub fn bound_norm(vector: &mut [f64], bound: f64) -> f64 {
    // Scaled by the largest entry: squares of exploding gradients would overflow.
    let largest = (vector.iter()).fold(0.0_f64, |most, value| most.max(value.abs()));
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let sum: f64 = vector.iter().map(|value| (value / scale).powi(2)).sum();
    let norm = scale * sum.sqrt();
    if norm > bound && norm.is_finite() {
        for value in vector {
            *value *= bound / norm;
        }
    }
    norm
}
