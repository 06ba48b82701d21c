//! Computes derivatives together with the values, in new vectors or in buffers of the caller.

use super::dense::Dense;
use super::gradient::swept;
use super::jacobian::{Values, set_columns, values_and_columns};
use super::seed::{CHUNK, Passes, WIDE, variables_from};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::Var;

/// Returns the values at `x` and the [`jacobian`](crate::jacobian), with one row per value and one column per argument.
/// The values cost nothing extra.
///
/// ```
/// use autodiff::{Real, value_and_jacobian};
///
/// let (values, jacobian) =
///     value_and_jacobian(|x| vec![x[0] * x[1].cos(), x[0] * x[1].sin()], &[2.0, 0.0]);
/// assert_eq!(values, [2.0, 0.0]);
/// assert_eq!(jacobian, [[1.0, 0.0], [0.0, 2.0]]);
/// ```
///
/// # Panics
/// If the number of values differs between passes.
#[track_caller]
pub fn value_and_jacobian<R: Real>(
    function: impl Fn(&[Dual<R, WIDE>]) -> Vec<Dual<R, WIDE>>,
    x: &[R],
) -> (Vec<R>, Dense<R>) {
    values_and_columns(&function, x)
}

/// Like [`value_and_jacobian`], but writes to buffers of the caller: one number per value, and the Jacobian row by row.
///
/// # Panics
/// If `values` does not have one number per value of the function, or `jacobian` does not have one number per value and
/// argument.
#[track_caller]
pub fn value_and_jacobian_into<R: Real>(
    function: impl Fn(&[Dual<R, WIDE>]) -> Vec<Dual<R, WIDE>>,
    x: &[R],
    values: &mut [R],
    jacobian: &mut [R],
) {
    let function: &Values<R> = &function;
    check(jacobian, values.len() * x.len(), "jacobian");
    let mut passes = Passes::new(x);
    while let Some(first) = passes.next() {
        let y = function(&passes.x);
        check(values, y.len(), "values");
        if first == 0 {
            for (value, y) in values.iter_mut().zip(&y) {
                *value = y.value;
            }
        }
        set_columns(jacobian, x.len(), first, &y);
    }
}

/// Like [`value_and_gradient`](crate::value_and_gradient), but writes the gradient to a buffer of the caller.
///
/// ```
/// use autodiff::value_and_gradient_into;
///
/// let mut gradient = [0.0; 2];
/// let value = value_and_gradient_into(|x| x[0] * x[1], &[2.0, 3.0], &mut gradient);
/// assert_eq!((value, gradient), (6.0, [3.0, 2.0]));
/// ```
///
/// # Panics
/// If `gradient` does not have one number per argument.
#[track_caller]
pub fn value_and_gradient_into<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Var<R>,
    x: &[R],
    gradient: &mut [R],
) -> R {
    check(gradient, x.len(), "gradient");
    swept(Box::new(function), x, &mut |slopes| {
        gradient.copy_from_slice(slopes)
    })
}

/// Returns the value, the gradient and the [`hessian`](crate::hessian) at `x`. The value and the gradient cost nothing
/// extra.
///
/// ```
/// use autodiff::value_gradient_hessian;
///
/// let (value, gradient, hessian) = value_gradient_hessian(|x| x[0] * x[0] * x[1], &[1.0, 2.0]);
/// assert_eq!((value, gradient), (2.0, vec![4.0, 1.0]));
/// assert_eq!(hessian, [[4.0, 2.0], [2.0, 0.0]]);
/// ```
#[track_caller]
pub fn value_gradient_hessian<R: Real>(
    function: impl Fn(&[Var<Dual<R, CHUNK>>]) -> Var<Dual<R, CHUNK>>,
    x: &[R],
) -> (R, Vec<R>, Dense<R>) {
    let n = x.len();
    let (mut gradient, mut hessian) = (vec![R::zero(); n], vec![R::zero(); n * n]);
    let value = value_gradient_hessian_into(function, x, &mut gradient, &mut hessian);
    (value, gradient, Dense::new(n, n, hessian))
}

/// Like [`value_gradient_hessian`], but returns only the value and writes to buffers of the caller: the gradient, and
/// the Hessian row by row.
///
/// # Panics
/// If `gradient` does not have one number per argument, or `hessian` does not have one number per pair of arguments.
#[track_caller]
pub fn value_gradient_hessian_into<R: Real>(
    function: impl Fn(&[Var<Dual<R, CHUNK>>]) -> Var<Dual<R, CHUNK>>,
    x: &[R],
    gradient: &mut [R],
    hessian: &mut [R],
) -> R {
    all_passes(&function, x, gradient, hessian)
}

/// A variable that carries several tangents.
type Nested<R> = Var<Dual<R, CHUNK>>;

/// Implements [`value_gradient_hessian_into`] for a function behind a reference, so that it is compiled once per number
/// type.
#[track_caller]
fn all_passes<R: Real>(
    function: &dyn Fn(&[Nested<R>]) -> Nested<R>,
    x: &[R],
    gradient: &mut [R],
    hessian: &mut [R],
) -> R {
    let n = x.len();
    check(gradient, n, "gradient");
    check(hessian, n * n, "hessian");
    let mut value = R::zero();
    // At least one pass, because it computes the value even if there are no arguments.
    for first in (0..n.max(1)).step_by(CHUNK) {
        let take = &mut |slopes: &[Dual<R, CHUNK>]| {
            for (j, slope) in slopes.iter().enumerate() {
                gradient[j] = slope.value;
                for (row, &second) in (first..n).zip(&slope.tangent) {
                    hessian[row * n + j] = second;
                }
            }
        };
        value = swept(Box::new(function), &variables_from(x, first), take).value;
    }
    value
}

#[track_caller]
fn check<R>(buffer: &[R], needed: usize, name: &str) {
    let found = buffer.len();
    assert!(
        found == needed,
        "the buffer `{name}` has {found} numbers; it must have {needed}"
    );
}
