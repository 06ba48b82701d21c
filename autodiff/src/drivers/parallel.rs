//! The drivers that use several cores (feature `rayon`).
//!
//! Each evaluation of the function stays on one thread. Only the passes over columns or rows are distributed over the
//! threads of rayon's current pool. No sum is split between threads, so results are bit-identical to those of the
//! serial drivers, for any number of threads. For gradients at many points, call
//! [`value_and_gradient`](crate::value_and_gradient) in a parallel iterator.
//!
//! The numbers may be floats, lanes, [`DoubleDouble`](crate::DoubleDouble) or duals of these. Variables of an outer
//! tape cause a panic, because a tape records only on its own thread. If there are so few arguments that all work stays
//! on the calling thread, the mistake may go unnoticed.

use rayon::prelude::*;

use super::dense::Dense;
use super::gradient::gradient;
use super::jacobian::joined_columns;
use super::seed::{CHUNK, WIDE, variables_from};
use super::sparse::Pattern;
use crate::dual::Dual;
use crate::real::Real;
use crate::reverse::{Tape, Var};

/// Like [`jacobian`](crate::jacobian), with the columns distributed over threads.
///
/// ```
/// use autodiff::{Real, parallel};
///
/// let polar = parallel::jacobian(|x| vec![x[0] * x[1].cos(), x[0] * x[1].sin()], &[2.0, 0.0]);
/// assert_eq!(polar, [[1.0, 0.0], [0.0, 2.0]]);
/// ```
#[track_caller]
pub fn jacobian<R: Real>(
    function: impl Fn(&[Dual<R, WIDE>]) -> Vec<Dual<R, WIDE>> + Sync,
    x: &[R],
) -> Dense<R> {
    let pass = |first| function(&variables_from(x, first));
    let passes = (0..x.len().max(1)).into_par_iter().step_by(WIDE);
    let passes: Vec<_> = passes.map(pass).collect();
    joined_columns(&mut passes.into_iter(), x.len())
}

/// Like [`jacobian_reverse`](crate::jacobian_reverse), with the rows distributed over threads.
#[track_caller]
pub fn jacobian_reverse<R: Real>(
    function: impl Fn(&[Var<R>]) -> Vec<Var<R>> + Sync,
    x: &[R],
) -> Dense<R> {
    let record = || {
        let mut tape = Tape::new();
        let y = tape.record(x, &function);
        (tape, y)
    };
    let row = |(tape, y): &mut (Tape<R>, Vec<Var<R>>), i: usize| {
        tape.pullback(&y[i..=i], &[R::one()]).to_vec()
    };
    // This recording finds the number of values, and refuses foreign variables on the thread of the caller. Each thread
    // that computes rows makes a recording of its own, which costs about as much as two sweeps.
    let (tape, y) = record();
    tape.assert_own(&y);
    let values = y.len();
    let rows = (0..values).into_par_iter().map_init(record, row);
    Dense::of_rows(x.len(), rows.collect())
}

/// Like [`sparse_jacobian`](crate::sparse_jacobian), with the colours distributed over threads.
///
/// # Panics
/// Like [`sparse_jacobian`](crate::sparse_jacobian).
#[track_caller]
pub fn sparse_jacobian<R: Real>(
    function: impl Fn(&[Dual<R, CHUNK>]) -> Vec<Dual<R, CHUNK>> + Sync,
    x: &[R],
    pattern: &Pattern,
) -> Vec<R> {
    pattern.check_arguments(x.len());
    let pass = |first| function(&pattern.along_directions(x, first));
    let passes: Vec<_> = firsts(pattern.directions()).map(pass).collect();
    pattern.decompressed(&mut passes.into_iter())
}

/// Like [`hessian`](crate::hessian), with the rows distributed over threads.
///
/// ```
/// use autodiff::parallel;
///
/// assert_eq!(parallel::hessian(|x| x[0] * x[0] * x[1], &[1.0, 2.0]), [[4.0, 2.0], [2.0, 0.0]]);
/// ```
#[track_caller]
pub fn hessian<R: Real>(
    function: impl Fn(&[Var<Dual<R, CHUNK>>]) -> Var<Dual<R, CHUNK>> + Sync,
    x: &[R],
) -> Dense<R> {
    let pass = |first| {
        let gradient = gradient(&function, &variables_from(x, first));
        let row = |i: usize| {
            gradient
                .iter()
                .map(|g: &Dual<R, CHUNK>| g.tangent[i])
                .collect()
        };
        (0..CHUNK.min(x.len() - first)).map(row).collect()
    };
    let rows: Vec<Vec<Vec<R>>> = firsts(x.len()).map(pass).collect();
    Dense::of_rows(x.len(), rows.concat())
}

/// Returns, for every pass, the index of its first column.
fn firsts(columns: usize) -> impl IndexedParallelIterator<Item = usize> {
    (0..columns).into_par_iter().step_by(CHUNK)
}
