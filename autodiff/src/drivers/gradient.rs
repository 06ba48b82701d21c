//! Computes gradients, by one reverse sweep or by forward passes.

use super::seed::{Passes, WIDE};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::{Var, keep_tape, recorded};

/// A scalar function of a vector, generic over its number type. Most drivers take closures. Only code that evaluates a
/// function in several number types, such as [`check_gradient`](crate::check::check_gradient), needs this trait.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not implement `Function`, the trait of functions that are generic over \
        their number type",
    note = "a closure has only one number type, but several are needed here; implement `Function` for a type"
)]
pub trait Function {
    /// Returns the value at `x`.
    fn eval<R: Real>(&self, x: &[R]) -> R;
}

/// Returns the gradient at `x`, by one reverse sweep.
///
/// ```
/// use autodiff::{Real, gradient};
///
/// assert_eq!(gradient(|x| 3.0 * x[0] * x[1].sin() + 1.0, &[2.0, 0.0]), [0.0, 6.0]);
/// ```
#[track_caller]
pub fn gradient<R: Real>(function: impl FnOnce(&[Var<R>]) -> Var<R>, x: &[R]) -> Vec<R> {
    value_and_gradient(function, x).1
}

/// Returns the value and the gradient at `x`, by one reverse sweep.
///
/// ```
/// use autodiff::{Real, value_and_gradient};
///
/// let (value, gradient) = value_and_gradient(|x| x[0] * x[1].exp(), &[2.0, 0.0]);
/// assert_eq!((value, gradient), (2.0, vec![1.0, 2.0]));
/// ```
#[track_caller]
pub fn value_and_gradient<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Var<R>,
    x: &[R],
) -> (R, Vec<R>) {
    let mut gradient = Vec::new();
    let value = swept(Box::new(function), x, &mut |slopes| {
        gradient = slopes.to_vec()
    });
    (value, gradient)
}

/// A boxed function of variables.
type Boxed<'f, R> = Box<dyn FnOnce(&[Var<R>]) -> Var<R> + 'f>;

/// Records the function, sweeps back, and gives the gradient to `take`. Returns the value. Both closures are behind
/// pointers, so that this is compiled once for each number type and not once for each closure.
#[track_caller]
pub(super) fn swept<R: Real>(function: Boxed<R>, x: &[R], take: &mut dyn FnMut(&[R])) -> R {
    let (mut tape, y) = recorded(function, x);
    take(tape.pullback(&[y], &[R::one()]));
    keep_tape(tape);
    y.value()
}

/// Returns the gradient at `x` in forward mode. Each forward pass computes the derivatives with respect to eight
/// arguments, so the function is called several times and must return the same value each time. There is no tape, and
/// for a dozen arguments this is faster than [`gradient`]. If the number of arguments
/// is fixed, [`value_and_gradient_array`](crate::value_and_gradient_array) is faster still.
///
/// ```
/// use autodiff::{Real, gradient_forward};
///
/// assert_eq!(gradient_forward(|x| x[0] * x[1].exp(), &[2.0, 0.0]), [1.0, 2.0]);
/// ```
#[track_caller]
pub fn gradient_forward<R: Real>(
    function: impl Fn(&[Dual<R, WIDE>]) -> Dual<R, WIDE>,
    x: &[R],
) -> Vec<R> {
    let mut gradient = Vec::with_capacity(x.len());
    let mut passes = Passes::new(x);
    while let Some(first) = passes.next() {
        let slopes = function(&passes.x).tangent;
        gradient.extend_from_slice(&slopes[..WIDE.min(x.len() - first)]);
    }
    gradient
}
