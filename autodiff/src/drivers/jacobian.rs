//! Computes Jacobians, and products of Jacobians with vectors.

use super::dense::Dense;
use super::seed::{CHUNK, along, seeded};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::{Var, with_tape};

/// Returns the values at `x` and their derivatives along `direction` (a JVP), by one forward pass.
///
/// ```
/// use autodiff::{Real, jvp};
///
/// let (y, y_dot) = jvp(|x| vec![x[0].sin(), 2.0 * x[0]], &[0.0], &[1.0]);
/// assert_eq!((y, y_dot), (vec![0.0, 0.0], vec![1.0, 2.0]));
/// ```
///
/// # Panics
/// If `x` and `direction` differ in length.
pub fn jvp<R: Real>(
    function: impl FnOnce(&[Dual<R, 1>]) -> Vec<Dual<R, 1>>,
    x: &[R],
    direction: &[R],
) -> (Vec<R>, Vec<R>) {
    parts(function(&along(x, direction)))
}

/// Returns the values and the tangents.
pub(super) fn parts<R: Real>(y: Vec<Dual<R, 1>>) -> (Vec<R>, Vec<R>) {
    y.into_iter().map(|y| (y.value, y.tangent[0])).unzip()
}

/// Returns the values at `x`, and the product of the cotangents `y_bar` with the Jacobian (a VJP), by one reverse
/// sweep.
///
/// ```
/// use autodiff::{Real, vjp};
///
/// let (_, x_bar) = vjp(|x| vec![x[0].sin(), 2.0 * x[0]], &[0.0], &[1.0, 1.0]);
/// assert_eq!(x_bar, [3.0]);
/// ```
///
/// # Panics
/// If `y_bar` does not have one cotangent per value.
pub fn vjp<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Vec<Var<R>>,
    x: &[R],
    y_bar: &[R],
) -> (Vec<R>, Vec<R>) {
    let function: VectorOf<'_, R> = Box::new(function);
    with_tape(|tape| {
        let y = tape.record(x, function);
        let x_bar = tape.pullback(&y, y_bar).to_vec();
        (y.into_iter().map(Var::value).collect(), x_bar)
    })
}

/// A boxed closure. Functions that take it are compiled once per number type, not once per closure.
type VectorOf<'a, R> = Box<dyn FnOnce(&[Var<R>]) -> Vec<Var<R>> + 'a>;

/// Returns the Jacobian at `x`, with one row per value and one column per argument. Each forward pass computes four
/// columns. Use [`jacobian_reverse`] if there are fewer values than arguments.
///
/// ```
/// use autodiff::{Real, jacobian};
///
/// let polar = jacobian(|x| vec![x[0] * x[1].cos(), x[0] * x[1].sin()], &[2.0, 0.0]);
/// assert_eq!(polar, [[1.0, 0.0], [0.0, 2.0]]);
/// ```
///
/// # Panics
/// If the number of values differs between passes.
pub fn jacobian<R: Real>(
    function: impl Fn(&[Dual<R, CHUNK>]) -> Vec<Dual<R, CHUNK>>,
    x: &[R],
) -> Dense<R> {
    columns(&function, x)
}

/// Implements [`jacobian`] for a function behind a reference, so that it is compiled once per number type.
#[allow(clippy::type_complexity)]
fn columns<R: Real>(
    function: &dyn Fn(&[Dual<R, CHUNK>]) -> Vec<Dual<R, CHUNK>>,
    x: &[R],
) -> Dense<R> {
    // At least one pass, because it finds the number of values even if there are no arguments.
    let passes = (0..x.len().max(1)).step_by(CHUNK);
    let mut passes = passes.map(|first| function(&seeded(x, first)));
    joined_columns(&mut passes, x.len())
}

/// Returns the Jacobian at `x`, with one row per value and one column per argument. The function is recorded once, and
/// each row takes one reverse sweep.
///
/// ```
/// use autodiff::jacobian_reverse;
///
/// let volume = jacobian_reverse(|x| vec![x[0] * x[1] * x[2]], &[1.0, 2.0, 3.0]);
/// assert_eq!(volume, [[6.0, 3.0, 2.0]]);
/// ```
pub fn jacobian_reverse<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Vec<Var<R>>,
    x: &[R],
) -> Dense<R> {
    let function: VectorOf<'_, R> = Box::new(function);
    with_tape(|tape| {
        let y = tape.record(x, function);
        let mut entries = Vec::with_capacity(y.len() * x.len());
        for value in y.chunks(1) {
            entries.extend_from_slice(tape.pullback(value, &[R::one()]));
        }
        Dense::new(y.len(), x.len(), entries)
    })
}

/// Assembles a Jacobian from several passes. Each pass has computed [`CHUNK`] columns.
pub(crate) fn joined_columns<R: Real>(
    passes: &mut dyn Iterator<Item = Vec<Dual<R, CHUNK>>>,
    columns: usize,
) -> Dense<R> {
    let (mut rows, mut entries) = (0, Vec::new());
    for (pass, y) in passes.enumerate() {
        if pass == 0 {
            rows = y.len();
            entries.resize(rows * columns, R::zero());
        }
        assert_eq!(
            y.len(),
            rows,
            "the function's number of values must not depend on its argument"
        );
        let first = pass * CHUNK;
        let width = CHUNK.min(columns - first);
        for (i, y) in y.iter().enumerate() {
            entries[i * columns + first..][..width].copy_from_slice(&y.tangent[..width]);
        }
    }
    Dense::new(rows, columns, entries)
}
