//! Derivatives of whole functions.
//!
//! A function to differentiate is a type with one generic method, [`Function`] or
//! [`VectorFunction`]: a closure cannot be generic over the number type, and each driver picks
//! its own. Parameters that are not differentiated are fields of the type. Where reverse mode is
//! all that is wanted, [`gradient_of`] and [`value_and_gradient_of`] take a closure.
//!
//! All drivers are generic over the number type of `x`, so they nest. A number of an outer derivative
//! enters an inner closure as a [`Var::constant`]: constant to the inner derivative, not to the outer
//! one.
//!
//! ```
//! use autodiff::{Var, gradient_of};
//! // d/da of d/dx (a x^2) at x = 3.
//! let slope = |a: &[Var<f64>]| {
//!     gradient_of(|x| Var::constant(a[0]) * x[0] * x[0], &[Var::constant(3.0)])[0]
//! };
//! assert_eq!(gradient_of(slope, &[5.0]), [6.0]);
//! ```
//!
//! Drivers of reverse mode keep the memory of their recording, up to a gigabyte, for the next call on
//! the same thread; a [`Tape`](crate::Tape) of one's own frees it when it is dropped.

use crate::forward::Dual;
use crate::real::Real;
use crate::reverse::{Var, with_tape};

/// A scalar function of a vector.
pub trait Function {
    /// The value at `x`.
    fn eval<R: Real>(&self, x: &[R]) -> R;
}

/// A vector function of a vector.
pub trait VectorFunction {
    /// The values at `x`; their number may not depend on the values in `x`.
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R>;
}

/// How many columns a forward pass of a Jacobian or a Hessian carries at once: enough to
/// share the primal's work, few enough to stay in registers.
pub(crate) const CHUNK: usize = 4;

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
/// assert_eq!(gradient_of(|x| x[0] * x[1].sin(), &[2.0, 0.0]), [0.0, 2.0]);
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

/// The values and their derivatives along `direction` (a JVP), by one forward pass.
///
/// ```
/// use autodiff::{Real, VectorFunction, jvp};
///
/// struct Polar;
/// impl VectorFunction for Polar {
///     fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
///         vec![x[0] * x[1].cos(), x[0] * x[1].sin()]
///     }
/// }
/// let (y, y_dot) = jvp(&Polar, &[2.0, 0.0], &[0.0, 1.0]);
/// assert_eq!((y, y_dot), (vec![2.0, 0.0], vec![0.0, 2.0]));
/// ```
///
/// # Panics
/// If `x` and `direction` differ in length.
pub fn jvp<R: Real>(function: &impl VectorFunction, x: &[R], direction: &[R]) -> (Vec<R>, Vec<R>) {
    let y = function.eval(&along(x, direction));
    y.into_iter().map(|y| (y.value, y.tangent[0])).unzip()
}

/// The values, and their cotangents `y_bar` pulled back to `x` (a VJP), by one reverse sweep.
///
/// ```
/// use autodiff::{Real, VectorFunction, vjp};
///
/// struct Polar;
/// impl VectorFunction for Polar {
///     fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
///         vec![x[0] * x[1].cos(), x[0] * x[1].sin()]
///     }
/// }
/// let (_, x_bar) = vjp(&Polar, &[2.0, 0.0], &[1.0, 1.0]);
/// assert_eq!(x_bar, [1.0, 2.0]);
/// ```
///
/// # Panics
/// If `y_bar` has not one cotangent per value.
pub fn vjp<R: Real>(function: &impl VectorFunction, x: &[R], y_bar: &[R]) -> (Vec<R>, Vec<R>) {
    with_tape(|tape| {
        let y = tape.record(x, |x| function.eval(x));
        let x_bar = tape.pullback(&y, y_bar).to_vec();
        (y.into_iter().map(Var::value).collect(), x_bar)
    })
}

/// The Jacobian, one row per value and one column per argument: by forward passes over four arguments
/// each where there are at least as many values as arguments, else by one reverse sweep per value. The
/// function is evaluated once more, to count its values.
///
/// ```
/// use autodiff::{Real, VectorFunction, jacobian};
///
/// struct Polar;
/// impl VectorFunction for Polar {
///     fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
///         vec![x[0] * x[1].cos(), x[0] * x[1].sin()]
///     }
/// }
/// assert_eq!(jacobian(&Polar, &[2.0, 0.0]), [[1.0, 0.0], [0.0, 2.0]]);
/// ```
///
/// # Panics
/// If the function has another number of values in one evaluation than in another.
pub fn jacobian<R: Real>(function: &impl VectorFunction, x: &[R]) -> Vec<Vec<R>> {
    let values = function.eval(x).len();
    if values >= x.len() {
        let passes = (0..x.len()).step_by(CHUNK);
        let passes = passes.map(|first| function.eval(&seeded(x, first)));
        return joined_columns(passes, x.len(), values);
    }
    with_tape(|tape| {
        let y = tape.record(x, |x| function.eval(x));
        assert_same_length(y.len(), values);
        let row = |i: usize| tape.pullback(&y[i..=i], &[R::one()]).to_vec();
        (0..values).map(row).collect()
    })
}

/// The rows of a Jacobian from its columns, of which each pass has [`CHUNK`].
pub(crate) fn joined_columns<R: Real>(
    passes: impl IntoIterator<Item = Vec<Dual<R, CHUNK>>>,
    columns: usize,
    values: usize,
) -> Vec<Vec<R>> {
    let mut rows = vec![Vec::with_capacity(columns); values];
    for (pass, y) in passes.into_iter().enumerate() {
        assert_same_length(y.len(), values);
        let width = CHUNK.min(columns - pass * CHUNK);
        for (row, y) in rows.iter_mut().zip(y) {
            row.extend_from_slice(&y.tangent[..width]);
        }
    }
    rows
}

/// Refuses a vector function whose values are not as many as before.
fn assert_same_length(now: usize, before: usize) {
    assert_eq!(
        now, before,
        "the function's number of values may not depend on its argument"
    );
}

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

/// `x` moving along a direction.
pub(crate) fn along<R: Real>(x: &[R], direction: &[R]) -> Vec<Dual<R, 1>> {
    assert_eq!(
        x.len(),
        direction.len(),
        "the direction needs one entry per argument"
    );
    let pairs = x.iter().zip(direction);
    let dual = |(&value, &tangent)| Dual {
        value,
        tangent: [tangent],
    };
    pairs.map(dual).collect()
}

/// `x`, of which the [`CHUNK`] arguments from place `first` on move, each along a direction of its own.
pub(crate) fn seeded<R: Real>(x: &[R], first: usize) -> Vec<Dual<R, CHUNK>> {
    let seed = |(i, &value)| {
        if (first..first + CHUNK).contains(&i) {
            Dual::variable(value, i - first)
        } else {
            Dual::constant(value)
        }
    };
    x.iter().enumerate().map(seed).collect()
}
