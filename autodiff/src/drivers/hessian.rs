//! Computes Hessians, by forward mode over reverse mode.

use super::dense::Dense;
use super::gradient::gradient;
use super::jacobian::parts;
use super::seed::{CHUNK, along};
use super::values::value_gradient_hessian;
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::Var;

/// Returns the gradient at `x` and the product of the Hessian with `direction`, by forward mode over reverse mode. For
/// any number of arguments this costs as much as a few gradients.
///
/// ```
/// use autodiff::hessian_vector;
///
/// let (gradient, product) =
///     hessian_vector(|x| x[0] * x[0] * x[1], &[1.0, 2.0], &[1.0, 0.0]);
/// assert_eq!((gradient, product), (vec![4.0, 1.0], vec![4.0, 2.0]));
/// ```
///
/// # Panics
/// If `x` and `direction` differ in length.
#[track_caller]
pub fn hessian_vector<R: Real>(
    function: impl FnOnce(&[Var<Dual<R, 1>>]) -> Var<Dual<R, 1>>,
    x: &[R],
    direction: &[R],
) -> (Vec<R>, Vec<R>) {
    parts(gradient(function, &along(x, direction)))
}

/// Returns the Hessian at `x`, by forward mode over reverse mode. Each pass computes four rows, so the function is
/// called several times and must return the same value each time. The upper and the lower triangle are computed
/// separately, so they agree only up to rounding.
///
/// ```
/// use autodiff::hessian;
///
/// assert_eq!(hessian(|x| x[0] * x[0] * x[1], &[1.0, 2.0]), [[4.0, 2.0], [2.0, 0.0]]);
/// ```
#[track_caller]
pub fn hessian<R: Real>(
    function: impl Fn(&[Var<Dual<R, CHUNK>>]) -> Var<Dual<R, CHUNK>>,
    x: &[R],
) -> Dense<R> {
    value_gradient_hessian(function, x).2
}
