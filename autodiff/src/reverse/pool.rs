//! A pool of tapes: one for each thread and number type.
//!
//! A driver that is called in a loop reuses the memory of its last call. Getting fresh pages from the system would cost
//! as much as a long recording and its sweep.

use super::tape::Tape;
use super::var::Var;
use crate::pool::{self, Pooled};
use crate::real::Real;

/// Records a function on the tape that the thread keeps, or on a new one. Give the tape back to [`keep_tape`]. Closures
/// around the recording and its sweeps would hide the line of the caller from panics.
#[track_caller]
pub(crate) fn recorded<R: Real, Y>(
    function: impl FnOnce(&[Var<R>]) -> Y,
    x: &[R],
) -> (Box<Tape<R>>, Y) {
    let mut tape = match pool::take::<Tape<R>>() {
        Some(tape) => tape,
        None => Box::new(Tape::new()),
    };
    let y = tape.record(x, function);
    (tape, y)
}

/// Keeps a tape for later calls on this thread. A panic drops it instead.
pub(crate) fn keep_tape<R: Real>(mut tape: Box<Tape<R>>) {
    // Fused entries may own data of the caller, so they must not stay in the pool.
    tape.forget();
    pool::keep(tape);
}

impl<R: Real> Pooled for Tape<R> {
    fn bytes(&self) -> usize {
        Tape::bytes(self)
    }
}
