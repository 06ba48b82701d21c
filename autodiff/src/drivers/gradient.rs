//! Gradients, by one reverse sweep.

use super::seed::{CHUNK, seeded};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::{Var, with_tape};

/// A scalar function of a vector.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a `Function`, which is generic over its numbers",
    note = "a closure, or a function `fn f<R: Real>(x: &[R]) -> R`, goes to the driver whose name ends in `_of`"
)]
pub trait Function {
    /// The value at `x`.
    fn eval<R: Real>(&self, x: &[R]) -> R;
}

/// The gradient, by one reverse sweep.
///
/// ```
/// use autodiff::{Function, Real, gradient};
///
/// struct Rosenbrock;
/// impl Function for Rosenbrock {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         let (valley, slope) = (x[1] - x[0] * x[0], R::one() - x[0]);
///         R::lit(100.0) * valley * valley + slope * slope
///     }
/// }
/// assert_eq!(gradient(&Rosenbrock, &[1.0, 1.0]), [0.0, 0.0]);
/// ```
pub fn gradient<R: Real>(function: &impl Function, x: &[R]) -> Vec<R> {
    value_and_gradient(function, x).1
}

/// The value and the gradient, by one reverse sweep.
///
/// ```
/// use autodiff::{Function, Real, value_and_gradient};
///
/// struct Product;
/// impl Function for Product {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         x[0] * x[1]
///     }
/// }
/// assert_eq!(value_and_gradient(&Product, &[2.0, 3.0]), (6.0, vec![3.0, 2.0]));
/// ```
pub fn value_and_gradient<R: Real>(function: &impl Function, x: &[R]) -> (R, Vec<R>) {
    value_and_gradient_of(|x| function.eval(x), x)
}

/// The gradient of a closure, by one reverse sweep: shorter than a type with [`Function`] where
/// no other mode is needed.
///
/// ```
/// use autodiff::{Real, gradient_of};
///
/// assert_eq!(gradient_of(|x| 3.0 * x[0] * x[1].sin() + 1.0, &[2.0, 0.0]), [0.0, 6.0]);
/// ```
pub fn gradient_of<R: Real>(function: impl FnOnce(&[Var<R>]) -> Var<R>, x: &[R]) -> Vec<R> {
    value_and_gradient_of(function, x).1
}

/// The value and the gradient of a closure, by one reverse sweep.
///
/// ```
/// use autodiff::{Real, value_and_gradient_of};
///
/// let (value, gradient) = value_and_gradient_of(|x| x[0] * x[1].exp(), &[2.0, 0.0]);
/// assert_eq!((value, gradient), (2.0, vec![1.0, 2.0]));
/// ```
pub fn value_and_gradient_of<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Var<R>,
    x: &[R],
) -> (R, Vec<R>) {
    with_tape(|tape| {
        let y = tape.record(x, function);
        (y.value(), tape.pullback(&[y], &[R::one()]).to_vec())
    })
}

/// The gradient by forward passes, each over four arguments: no tape, and so faster than [`gradient`] for
/// a handful of arguments.
///
/// ```
/// use autodiff::{Function, Real, gradient_forward};
///
/// struct Product;
/// impl Function for Product {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         x[0] * x[1]
///     }
/// }
/// assert_eq!(gradient_forward(&Product, &[2.0, 3.0]), [3.0, 2.0]);
/// ```
pub fn gradient_forward<R: Real>(function: &impl Function, x: &[R]) -> Vec<R> {
    gradient_forward_of(|x| function.eval(x), x)
}

/// The gradient of a closure by forward passes, each over four arguments.
///
/// ```
/// use autodiff::{Real, gradient_forward_of};
///
/// assert_eq!(gradient_forward_of(|x| x[0] * x[1].exp(), &[2.0, 0.0]), [1.0, 2.0]);
/// ```
pub fn gradient_forward_of<R: Real>(
    function: impl Fn(&[Dual<R, CHUNK>]) -> Dual<R, CHUNK>,
    x: &[R],
) -> Vec<R> {
    let passes = (0..x.len()).step_by(CHUNK);
    let slopes = passes.flat_map(|first| function(&seeded(x, first)).tangent);
    slopes.take(x.len()).collect()
}
