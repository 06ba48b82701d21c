//! Hessians, forward over reverse.

use super::dense::Dense;
use super::gradient::{Function, gradient_of};
use super::seed::{CHUNK, along, seeded};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::Var;

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
    hessian_vector_of(|x| function.eval(x), x, direction)
}

/// [`hessian_vector`] of a closure.
///
/// ```
/// use autodiff::hessian_vector_of;
///
/// let (_, product) = hessian_vector_of(|x| x[0] * x[0] * x[1], &[1.0, 2.0], &[1.0, 0.0]);
/// assert_eq!(product, [4.0, 2.0]);
/// ```
///
/// # Panics
/// As [`hessian_vector`].
pub fn hessian_vector_of<R: Real>(
    function: impl FnOnce(&[Var<Dual<R, 1>>]) -> Var<Dual<R, 1>>,
    x: &[R],
    direction: &[R],
) -> (Vec<R>, Vec<R>) {
    let gradient = gradient_of(function, &along(x, direction));
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
pub fn hessian<R: Real>(function: &impl Function, x: &[R]) -> Dense<R> {
    hessian_of(|x| function.eval(x), x)
}

/// The Hessian of a closure.
///
/// ```
/// use autodiff::hessian_of;
///
/// assert_eq!(hessian_of(|x| x[0] * x[0] * x[1], &[1.0, 2.0]), [[4.0, 2.0], [2.0, 0.0]]);
/// ```
pub fn hessian_of<R: Real>(
    function: impl Fn(&[Var<Dual<R, CHUNK>>]) -> Var<Dual<R, CHUNK>>,
    x: &[R],
) -> Dense<R> {
    let passes = (0..x.len()).step_by(CHUNK);
    let rows = passes.flat_map(|first| hessian_rows(&function, x, first));
    Dense::of_rows(x.len(), rows.collect())
}

/// The rows of the Hessian from `first` on, as many as one pass computes.
pub(crate) fn hessian_rows<R: Real>(
    function: impl Fn(&[Var<Dual<R, CHUNK>>]) -> Var<Dual<R, CHUNK>>,
    x: &[R],
    first: usize,
) -> Vec<Vec<R>> {
    let gradient = gradient_of(function, &seeded(x, first));
    let row = |i: usize| gradient.iter().map(|g| g.tangent[i]).collect();
    (0..CHUNK.min(x.len() - first)).map(row).collect()
}
