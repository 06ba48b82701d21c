//! Jacobians, and their products with vectors.

use super::dense::Dense;
use super::seed::{CHUNK, along, seeded};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::{Var, with_tape};

/// A vector function of a vector.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a `VectorFunction`, which is generic over its numbers",
    note = "a closure, or a function `fn f<R: Real>(x: &[R]) -> Vec<R>`, goes to the driver whose name ends in `_of`"
)]
pub trait VectorFunction {
    /// The values at `x`; their number may not depend on the values in `x`.
    fn eval<R: Real>(&self, x: &[R]) -> Vec<R>;
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
    jvp_of(|x| function.eval(x), x, direction)
}

/// [`jvp`] of a closure.
///
/// ```
/// use autodiff::{Real, jvp_of};
///
/// let (y, y_dot) = jvp_of(|x| vec![x[0].sin(), 2.0 * x[0]], &[0.0], &[1.0]);
/// assert_eq!((y, y_dot), (vec![0.0, 0.0], vec![1.0, 2.0]));
/// ```
///
/// # Panics
/// As [`jvp`].
pub fn jvp_of<R: Real>(
    function: impl FnOnce(&[Dual<R, 1>]) -> Vec<Dual<R, 1>>,
    x: &[R],
    direction: &[R],
) -> (Vec<R>, Vec<R>) {
    let y = function(&along(x, direction));
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
    vjp_of(|x| function.eval(x), x, y_bar)
}

/// [`vjp`] of a closure.
///
/// ```
/// use autodiff::{Real, vjp_of};
///
/// let (_, x_bar) = vjp_of(|x| vec![x[0].sin(), 2.0 * x[0]], &[0.0], &[1.0, 1.0]);
/// assert_eq!(x_bar, [3.0]);
/// ```
///
/// # Panics
/// As [`vjp`].
pub fn vjp_of<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Vec<Var<R>>,
    x: &[R],
    y_bar: &[R],
) -> (Vec<R>, Vec<R>) {
    with_tape(|tape| {
        let y = tape.record(x, function);
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
pub fn jacobian<R: Real>(function: &impl VectorFunction, x: &[R]) -> Dense<R> {
    let values = function.eval(x).len();
    if values >= x.len() {
        let passes = (0..x.len()).step_by(CHUNK);
        let passes = passes.map(|first| function.eval(&seeded(x, first)));
        return joined_columns(passes, x.len(), Some(values));
    }
    with_tape(|tape| {
        let y = tape.record(x, |x| function.eval(x));
        assert_same_length(y.len(), values);
        let mut entries = Vec::with_capacity(values * x.len());
        for i in 0..values {
            entries.extend_from_slice(tape.pullback(&y[i..=i], &[R::one()]));
        }
        Dense::new(values, x.len(), entries)
    })
}

/// The Jacobian of a closure, by forward passes over four arguments each. For a few values of many
/// arguments [`vjp_of`] gives a row at a time, and [`jacobian`] chooses.
///
/// ```
/// use autodiff::{Real, jacobian_of};
///
/// let polar = jacobian_of(|x| vec![x[0] * x[1].cos(), x[0] * x[1].sin()], &[2.0, 0.0]);
/// assert_eq!(polar, [[1.0, 0.0], [0.0, 2.0]]);
/// ```
///
/// # Panics
/// If the function has another number of values in one evaluation than in another.
pub fn jacobian_of<R: Real>(
    function: impl Fn(&[Dual<R, CHUNK>]) -> Vec<Dual<R, CHUNK>>,
    x: &[R],
) -> Dense<R> {
    // Without arguments one pass still counts the values.
    let passes = (0..x.len().max(1)).step_by(CHUNK);
    joined_columns(
        passes.map(|first| function(&seeded(x, first))),
        x.len(),
        None,
    )
}

/// A Jacobian from its columns, of which each pass has [`CHUNK`]. `values` is how many rows there are, if
/// that is known before.
pub(crate) fn joined_columns<R: Real>(
    passes: impl IntoIterator<Item = Vec<Dual<R, CHUNK>>>,
    columns: usize,
    values: Option<usize>,
) -> Dense<R> {
    let (mut rows, mut entries) = (values, Vec::new());
    for (pass, y) in passes.into_iter().enumerate() {
        let values = *rows.get_or_insert(y.len());
        assert_same_length(y.len(), values);
        entries.resize(values * columns, R::zero());
        let first = pass * CHUNK;
        let width = CHUNK.min(columns - first);
        for (i, y) in y.iter().enumerate() {
            entries[i * columns + first..][..width].copy_from_slice(&y.tangent[..width]);
        }
    }
    Dense::new(rows.unwrap_or(0), columns, entries)
}

/// Refuses a vector function whose values are not as many as before.
fn assert_same_length(now: usize, before: usize) {
    assert_eq!(
        now, before,
        "the function's number of values may not depend on its argument"
    );
}
