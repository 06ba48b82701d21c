//! Computes Jacobians, and products of Jacobians with vectors.

use super::dense::Dense;
use super::seed::{Passes, WIDE, along};
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::{Var, keep_tape, recorded};

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
#[track_caller]
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
#[track_caller]
pub fn vjp<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Vec<Var<R>>,
    x: &[R],
    y_bar: &[R],
) -> (Vec<R>, Vec<R>) {
    let function: VectorOf<'_, R> = Box::new(function);
    let (mut tape, y) = recorded(function, x);
    let x_bar = tape.pullback(&y, y_bar).to_vec();
    keep_tape(tape);
    (y.into_iter().map(Var::value).collect(), x_bar)
}

/// A boxed closure. Functions that take it are compiled once per number type, not once per closure.
type VectorOf<'a, R> = Box<dyn FnOnce(&[Var<R>]) -> Vec<Var<R>> + 'a>;

/// Returns the Jacobian at `x`, with one row per value and one column per argument. Each forward pass computes eight
/// columns, so the function is called once for every eight arguments and must return the same values each time. Use
/// [`jacobian_reverse`] if there are fewer values than arguments.
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
#[track_caller]
pub fn jacobian<R: Real>(
    function: impl Fn(&[Dual<R, WIDE>]) -> Vec<Dual<R, WIDE>>,
    x: &[R],
) -> Dense<R> {
    values_and_columns(&function, x).1
}

/// A function with several values, in forward mode.
pub(super) type Values<'f, R> = dyn Fn(&[Dual<R, WIDE>]) -> Vec<Dual<R, WIDE>> + 'f;

/// Returns the values and the Jacobian. The function is behind a reference, so that this is compiled once per number
/// type.
#[track_caller]
pub(super) fn values_and_columns<R: Real>(function: &Values<R>, x: &[R]) -> (Vec<R>, Dense<R>) {
    let mut joined = Joined::new(x.len());
    let mut passes = Passes::new(x);
    while let Some(first) = passes.next() {
        joined.add(first, &function(&passes.x));
    }
    let values = joined.values.clone();
    (values, joined.into_dense())
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
#[track_caller]
pub fn jacobian_reverse<R: Real>(
    function: impl FnOnce(&[Var<R>]) -> Vec<Var<R>>,
    x: &[R],
) -> Dense<R> {
    let function: VectorOf<'_, R> = Box::new(function);
    let (mut tape, y) = recorded(function, x);
    let mut entries = Vec::with_capacity(y.len() * x.len());
    for value in y.chunks(1) {
        entries.extend_from_slice(tape.pullback(value, &[R::one()]));
    }
    keep_tape(tape);
    Dense::new(y.len(), x.len(), entries)
}

/// Assembles a Jacobian from several passes. Each pass has computed `N` columns.
#[track_caller]
pub(crate) fn joined_columns<R: Real, const N: usize>(
    passes: &mut dyn Iterator<Item = Vec<Dual<R, N>>>,
    columns: usize,
) -> Dense<R> {
    let mut joined = Joined::new(columns);
    for (pass, y) in passes.enumerate() {
        joined.add(pass * N, &y);
    }
    joined.into_dense()
}

/// Sets the columns from column `first` on, in the entries of a Jacobian row by row, given the values of the pass that
/// computed them.
pub(super) fn set_columns<R: Real, const N: usize>(
    entries: &mut [R],
    columns: usize,
    first: usize,
    y: &[Dual<R, N>],
) {
    for (row, y) in entries.chunks_exact_mut(columns.max(1)).zip(y) {
        let row = &mut row[first..];
        // A copy of a fixed length takes few instructions.
        match row.first_chunk_mut() {
            Some(row) => *row = y.tangent,
            None => row.copy_from_slice(&y.tangent[..row.len()]),
        }
    }
}

/// A Jacobian of which some columns are known.
struct Joined<R> {
    values: Vec<R>,
    columns: usize,
    entries: Vec<R>,
}

impl<R: Real> Joined<R> {
    fn new(columns: usize) -> Self {
        Self {
            values: Vec::new(),
            columns,
            entries: Vec::new(),
        }
    }

    /// Adds the columns from column `first` on, given the values of the pass that computed them.
    #[track_caller]
    fn add<const N: usize>(&mut self, first: usize, y: &[Dual<R, N>]) {
        if first == 0 {
            self.values.extend(y.iter().map(|y| y.value));
            self.entries.resize(y.len() * self.columns, R::zero());
        }
        assert_eq!(
            y.len(),
            self.values.len(),
            "the function's number of values must not depend on its argument"
        );
        set_columns(&mut self.entries, self.columns, first, y);
    }

    fn into_dense(self) -> Dense<R> {
        Dense::new(self.values.len(), self.columns, self.entries)
    }
}
