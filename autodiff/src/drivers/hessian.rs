//! Hessians, forward over reverse.

use super::gradient::{Function, gradient};
use super::seed::{CHUNK, along, seeded};
use crate::real::Real;

/// The gradient and the product of the Hessian with `direction`, forward over reverse: the cost
/// of a few gradients, whatever the number of arguments.
///
/// ```
/// use autodiff::{Function, Real, hessian_vector};
///
/// struct Cubic;
/// impl Function for Cubic {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         x[0] * x[0] * x[1]
///     }
/// }
/// let (gradient, product) = hessian_vector(&Cubic, &[1.0, 2.0], &[1.0, 0.0]);
/// assert_eq!((gradient, product), (vec![4.0, 1.0], vec![4.0, 2.0]));
/// ```
///
/// # Panics
/// If `x` and `direction` differ in length.
pub fn hessian_vector<R: Real>(
    function: &impl Function,
    x: &[R],
    direction: &[R],
) -> (Vec<R>, Vec<R>) {
    let gradient = gradient(function, &along(x, direction));
    gradient
        .into_iter()
        .map(|g| (g.value, g.tangent[0]))
        .unzip()
}

/// The Hessian, forward over reverse, four rows at a time. Its two triangles are computed separately
/// and agree up to rounding.
///
/// ```
/// use autodiff::{Function, Real, hessian};
///
/// struct Cubic;
/// impl Function for Cubic {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         x[0] * x[0] * x[1]
///     }
/// }
/// assert_eq!(hessian(&Cubic, &[1.0, 2.0]), [[4.0, 2.0], [2.0, 0.0]]);
/// ```
pub fn hessian<R: Real>(function: &impl Function, x: &[R]) -> Vec<Vec<R>> {
    let passes = (0..x.len()).step_by(CHUNK);
    passes
        .flat_map(|first| hessian_rows(function, x, first))
        .collect()
}

/// The rows of the Hessian from `first` on, as many as one pass computes.
pub(crate) fn hessian_rows<R: Real>(
    function: &impl Function,
    x: &[R],
    first: usize,
) -> Vec<Vec<R>> {
    let gradient = gradient(function, &seeded(x, first));
    let row = |i: usize| gradient.iter().map(|g| g.tangent[i]).collect();
    (0..CHUNK.min(x.len() - first)).map(row).collect()
}
