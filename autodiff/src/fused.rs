//! Functions that the reverse tape takes as one entry.

use crate::real::{Fused, Real};

/// A dense layer, `weights * x + biases`, as one entry of the tape; `weights` row by row.
///
/// ```
/// use autodiff::{Var, fused::dense, gradient_of};
///
/// let weights = [1.0, 2.0, 3.0, 4.0];
/// let by_x = gradient_of(
///     |x: &[Var<f64>]| {
///         let y = dense(&weights.map(Var::constant), x, &[Var::constant(0.5); 2]);
///         y[0] * y[1]
///     },
///     &[1.0, -1.0],
/// );
/// assert_eq!(by_x, [-2.0, -3.0]); // y = (-0.5, -0.5) times the columns' sums (4, 6)
/// ```
///
/// # Panics
/// Unless there are `biases.len() * x.len()` weights.
pub fn dense<R: Real>(weights: &[R], x: &[R], biases: &[R]) -> Vec<R> {
    assert_eq!(
        weights.len(),
        x.len() * biases.len(),
        "dense: the weights are not one row per bias and one column per number of x"
    );
    R::fused(Dense, &[weights, x, biases])
}

/// The inputs are weights, `x` and biases.
struct Dense;

impl Fused for Dense {
    /// The weights and `x`.
    type Saved<R: Real> = [Vec<R>; 2];

    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R> {
        let &[weights, x, biases] = inputs else {
            unreachable!("`dense` gives three slices")
        };
        if x.is_empty() {
            return biases.to_vec();
        }
        weights
            .chunks_exact(x.len())
            .zip(biases)
            .map(|(row, &bias)| R::dot(row, x) + bias)
            .collect()
    }

    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, [Vec<R>; 2]) {
        (self.eval(inputs), [inputs[0].to_vec(), inputs[1].to_vec()])
    }

    fn reverse<R: Real>(
        &self,
        [weights, x]: &mut [Vec<R>; 2],
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>> {
        let mut weights_bar = Vec::new();
        if wanted[0] {
            let row = |&bar: &R| x.iter().map(move |&x| R::chain(x, bar)).collect::<Vec<R>>();
            weights_bar = y_bar.iter().flat_map(row).collect();
        }
        let mut x_bar = vec![R::zero(); if wanted[1] { x.len() } else { 0 }];
        for (row, &bar) in weights.chunks_exact(x.len().max(1)).zip(y_bar) {
            for (x_bar, &weight) in x_bar.iter_mut().zip(row) {
                *x_bar = R::chain_add(weight, bar, *x_bar);
            }
        }
        vec![weights_bar, x_bar, y_bar.to_vec()]
    }
}
