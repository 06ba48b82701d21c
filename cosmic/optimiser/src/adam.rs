//! Adam, a gradient method with an adaptive step length for every variable.
//!
//! D. P. Kingma and J. Ba, "Adam: a method for stochastic optimization", ICLR 2015, algorithm 1.

use crate::error::{OptimiserError, check, check_length};

/// The optimisation method Adam. The learning rate is an argument of each update.
#[derive(Debug, Clone, PartialEq)]
pub struct Adam {
    /// The decays of the mean of the gradient and of the mean of its square, each from 0 to below 1. 0.9 and 0.999 by
    /// default.
    pub betas: [f64; 2],
    /// A positive number that keeps the update from dividing by zero. 1e-8 by default.
    pub epsilon: f64,
}

impl Default for Adam {
    fn default() -> Self {
        Adam {
            betas: [0.9, 0.999],
            epsilon: 1e-8,
        }
    }
}

/// The state of Adam between updates.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct AdamState {
    /// The number of updates so far.
    pub updates: u64,
    /// The decaying mean of the gradient, without bias correction.
    pub mean: Vec<f64>,
    /// The decaying mean of the squared gradient, without bias correction.
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

    /// Does one update: moves `variables` against the gradient. No variable moves by much more than `rate`.
    ///
    /// # Errors
    /// If a slice has the wrong length, or if the gradient or its squares are not finite. In these cases, state and
    /// variables do not change.
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
        if gradient.iter().any(|slope| !(slope * slope).is_finite()) {
            return Err(OptimiserError::Overflow);
        }
        state.updates += 1;
        let ([beta1, beta2], epsilon) = (self.betas, self.epsilon);
        let correct1 = bias_correction(beta1, state.updates);
        let correct2 = bias_correction(beta2, state.updates);
        for (j, &slope) in gradient.iter().enumerate() {
            let (mean, square) = (&mut state.mean[j], &mut state.mean_square[j]);
            *mean = beta1 * *mean + (1.0 - beta1) * slope;
            *square = beta2 * *square + (1.0 - beta2) * slope * slope;
            let step = *mean / correct1 / ((*square / correct2).sqrt() + epsilon);
            variables[j] -= rate * step;
        }
        Ok(())
    }
}

/// The sum of the weights of all values in a decaying mean that started at 0: `1 - decay^updates`. Dividing the mean by
/// this sum corrects its bias towards 0.
fn bias_correction(decay: f64, updates: u64) -> f64 {
    // An integer power is a product, which has the same bits on every machine.
    1.0 - decay.powi(i32::try_from(updates).unwrap_or(i32::MAX))
}

/// Scales a vector down to the Euclidean norm `bound` if its norm is larger. Returns the norm before scaling.
///
/// If an entry is not finite, the vector does not change and the returned norm is not finite. If the norm exceeds the
/// largest f64, the returned norm is infinite.
pub fn bound_norm(vector: &mut [f64], bound: f64) -> f64 {
    // The entries are divided by the largest one before they are squared, because the squares of exploding gradients
    // would overflow.
    let largest = (vector.iter()).fold(0.0_f64, |most, value| most.max(value.abs()));
    let scale = if largest > 0.0 { largest } else { 1.0 };
    let sum: f64 = vector.iter().map(|value| (value / scale).powi(2)).sum();
    let norm = scale * sum.sqrt();
    if norm > bound && scale.is_finite() {
        // If the norm overflows, the divided entries are scaled by their own norm instead.
        let [scale, norm] = if norm.is_finite() {
            [1.0, norm]
        } else {
            [scale, sum.sqrt()]
        };
        for value in vector {
            *value = *value / scale * (bound / norm);
        }
    }
    norm
}
