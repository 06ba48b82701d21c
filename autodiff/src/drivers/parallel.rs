//! The drivers on several cores (feature `rayon`).
//!
//! Each evaluation of the function stays on one thread; the passes over columns or rows are distributed.
//! For gradients at many points, call [`value_and_gradient`](crate::value_and_gradient) in a parallel iterator. No sum runs across threads, so results are the serial drivers' to the bit,
//! whatever the number of threads. They run in rayon's current pool.
//!
//! The numbers may be floats, lanes, [`DoubleDouble`](crate::DoubleDouble) or duals of these, but not variables of
//! an outer tape, because a tape records on its own thread only: using them on another panics. (With few
//! arguments all work may stay on the calling thread, and the mistake go unnoticed.)

use rayon::prelude::*;

use super::dense::Dense;
use super::gradient::Function;
use super::hessian::hessian_rows;
use super::jacobian::{VectorFunction, joined_columns};
use super::seed::{CHUNK, seeded};
use super::sparse::Pattern;
use crate::real::Real;
use crate::reverse::{Tape, Var};

/// [`jacobian`](crate::jacobian), its columns or rows shared out among threads.
///
/// ```
/// use autodiff::{Real, VectorFunction, parallel};
///
/// struct Polar;
/// impl VectorFunction for Polar {
///     fn eval<R: Real>(&self, x: &[R]) -> Vec<R> {
///         vec![x[0] * x[1].cos(), x[0] * x[1].sin()]
///     }
/// }
/// assert_eq!(parallel::jacobian(&Polar, &[2.0, 0.0]), [[1.0, 0.0], [0.0, 2.0]]);
/// ```
pub fn jacobian<R: Real>(function: &(impl VectorFunction + Sync), x: &[R]) -> Dense<R> {
    let values = function.eval(x).len();
    if values >= x.len() {
        let pass = |first| function.eval(&seeded(x, first));
        let passes: Vec<_> = firsts(x.len()).map(pass).collect();
        return joined_columns(passes, x.len(), Some(values));
    }
    // Each share of the rows makes a recording of its own, which costs about as much as two sweeps.
    let record = || {
        let mut tape = Tape::new();
        let y = tape.record(x, |x| function.eval(x));
        (tape, y)
    };
    let row = |(tape, y): &mut (Tape<R>, Vec<Var<R>>), i: usize| {
        tape.pullback(&y[i..=i], &[R::one()]).to_vec()
    };
    let rows = (0..values).into_par_iter().map_init(record, row);
    Dense::of_rows(x.len(), rows.collect())
}

/// [`sparse_jacobian`](crate::sparse_jacobian), its colours shared out among threads.
///
/// # Panics
/// As the serial one.
pub fn sparse_jacobian<R: Real>(
    function: &(impl VectorFunction + Sync),
    x: &[R],
    pattern: &Pattern,
) -> Vec<R> {
    let pass = |first| function.eval(&pattern.seeded(x, first));
    let passes: Vec<_> = firsts(pattern.directions()).map(pass).collect();
    pattern.decompressed(passes.into_iter())
}

/// [`hessian`](crate::hessian), its rows shared out among threads.
///
/// ```
/// use autodiff::{Function, Real, parallel};
///
/// struct Cubic;
/// impl Function for Cubic {
///     fn eval<R: Real>(&self, x: &[R]) -> R {
///         x[0] * x[0] * x[1]
///     }
/// }
/// assert_eq!(parallel::hessian(&Cubic, &[1.0, 2.0]), [[4.0, 2.0], [2.0, 0.0]]);
/// ```
pub fn hessian<R: Real>(function: &(impl Function + Sync), x: &[R]) -> Dense<R> {
    let rows: Vec<Vec<Vec<R>>> = firsts(x.len())
        .map(|first| hessian_rows(|x| function.eval(x), x, first))
        .collect();
    Dense::of_rows(x.len(), rows.concat())
}

/// The first column of every pass.
fn firsts(columns: usize) -> impl IndexedParallelIterator<Item = usize> {
    (0..columns).into_par_iter().step_by(CHUNK)
}
