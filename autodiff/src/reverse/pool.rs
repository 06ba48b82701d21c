//! A pool of tapes: one for each thread and number type.
//!
//! A driver that is called in a loop reuses the memory of its last call. Getting fresh pages from the system would cost
//! as much as a long recording and its sweep.

use super::tape::Tape;
use crate::pool::{self, Pooled};
use crate::real::Real;

/// Takes the tape that the thread keeps, or makes one. Give it back to [`keep_tape`]. A closure would hide the line of the
/// caller from panics.
#[track_caller]
pub(crate) fn take_tape<R: Real>() -> Box<Tape<R>> {
    match pool::take::<Tape<R>>() {
        Some(tape) => tape,
        None => Box::new(Tape::new()),
    }
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

#[cfg(test)]
mod tests {
    use super::{keep_tape, take_tape};
    use crate::pool::count;
    use crate::real::Real;
    use crate::reverse::{Tape, Var};
    use crate::{Dual, gradient};

    fn with_tape<R: Real, T>(work: impl FnOnce(&mut Tape<R>) -> T) -> T {
        let mut tape = take_tape();
        let result = work(&mut tape);
        keep_tape(tape);
        result
    }

    fn long(x: Var<f64>, entries: usize) -> Var<f64> {
        (0..entries).fold(x, |y, _| y * x)
    }

    #[test]
    #[cfg_attr(target_family = "wasm", ignore = "no threads: tests share one")]
    fn a_thread_keeps_one_tape_of_a_type() {
        let capacity = |tape: &mut Tape<f64>| tape.bytes();
        assert_eq!(with_tape(capacity), 0);
        assert_eq!(gradient(|x| long(x[0], 1000), &[1.0]), [1001.0]);
        let kept = with_tape(capacity);
        assert!(kept >= 24 * 1000);
        with_tape(|_: &mut Tape<Dual<f64, 2>>| {
            with_tape(|_: &mut Tape<f32>| assert_eq!(count(), 1))
        });
        assert_eq!((count(), with_tape(capacity)), (3, kept));
    }

    #[test]
    #[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
    fn a_tape_is_not_used_again_after_a_panic() {
        let left = std::panic::catch_unwind(|| gradient(|_: &[Var<f64>]| panic!("left"), &[1.0]));
        assert!(left.is_err());
        assert_eq!(gradient(|x| x[0] * x[0], &[3.0]), [6.0]);
    }
}
