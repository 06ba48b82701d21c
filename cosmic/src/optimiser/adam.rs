//! Adam, a gradient method with an adaptive step length for every variable.
//!
//! D. P. Kingma and J. Ba, "Adam: a method for stochastic optimization", ICLR 2015, algorithm 1.

use serde::{Deserialize, Serialize};

use super::error::{OptimiserError, check, check_length};
use crate::scene::AdamSettings;

/// The optimisation method Adam. Of its settings it uses only `betas` and `epsilon`. The learning rate is an argument
/// of each update.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adam(pub AdamSettings);

/// The state of Adam between updates.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
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
        let ([beta1, beta2], epsilon) = (self.0.betas, self.0.epsilon);
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

#[cfg(test)]
mod tests {
    use super::{Adam, bound_norm};

    /// The paper's mean as a sum (section 3): `m_t = (1 - beta) sum_i beta^(t - i) g_i`, divided by `1 - beta^t`.
    fn corrected_mean(decay: f64, values: &[f64]) -> f64 {
        let last = values.len() as i32;
        let weighted: f64 = (values.iter().zip(1..))
            .map(|(value, i)| (1.0 - decay) * decay.powi(last - i) * value)
            .sum();
        weighted / (1.0 - decay.powi(last))
    }

    #[test]
    fn steps_are_those_of_the_weighted_means() {
        let (adam, rate) = (Adam::default(), 0.1);
        let mut state = adam.init(1);
        let mut x = [2.0];
        let (mut slopes, mut squares) = (Vec::new(), Vec::new());
        for _ in 0..50 {
            let (before, slope) = (x[0], 3.0 * x[0]);
            slopes.push(slope);
            squares.push(slope * slope);
            adam.update(&mut state, &mut x, &[slope], rate).unwrap();
            let mean = corrected_mean(adam.0.betas[0], &slopes);
            let square = corrected_mean(adam.0.betas[1], &squares);
            let expected = before - rate * mean / (square.sqrt() + adam.0.epsilon);
            // The rounding error is 1e-16 * 50 * 1e3: fifty terms, some with opposite signs, are divided by
            // 1 - beta2 = 1e-3.
            assert!((x[0] - expected).abs() < 1e-11, "{} {expected}", x[0]);
        }
    }

    #[test]
    fn bad_gradients_change_nothing() {
        let adam = Adam::default();
        let (mut state, mut x) = (adam.init(2), [1.0, 2.0]);
        let huge = [1.0, 1e155];
        for bad in [&[1.0, f64::NAN][..], &[f64::INFINITY, 0.0], &huge, &[1.0]] {
            assert!(adam.update(&mut state, &mut x, bad, 0.1).is_err());
        }
        assert_eq!((state, x), (adam.init(2), [1.0, 2.0]));
    }

    #[test]
    fn norms_are_bounded() {
        let mut long = [3.0, 4.0];
        assert_eq!(bound_norm(&mut long, 2.5), 5.0);
        assert_eq!(long, [1.5, 2.0]);
        let mut short = [0.3, 0.4];
        bound_norm(&mut short, 1.0);
        assert_eq!(short, [0.3, 0.4]);
        // The square of this number would overflow. It is a power of two, so that nothing is rounded.
        let big = 2.0_f64.powi(700);
        assert_eq!(bound_norm(&mut [3.0 * big, 4.0 * big], 5.0), 5.0 * big);
        // Here the norm itself overflows.
        let mut largest = [f64::MAX; 4];
        assert_eq!(bound_norm(&mut largest, 5.0), f64::INFINITY);
        assert_eq!(largest, [2.5; 4]);
        assert_eq!(bound_norm(&mut [0.0, 0.0], 1.0), 0.0);
        for bad in [f64::NAN, f64::INFINITY] {
            let mut vector = [1.0, bad, 0.0];
            assert!(!bound_norm(&mut vector, 1.0).is_finite());
            assert_eq!(vector[0], 1.0);
        }
        assert!(bound_norm(&mut [0.0, f64::NAN], 1.0).is_nan());
    }
}
