//! Tapes that are done with, for the thread's next gradient.
//!
//! A driver that is called in a loop reuses the memory of its last call: fresh pages would cost as much
//! as a long recording and its sweep do.

use super::tape::Tape;
use crate::pool;
use crate::real::Real;

/// A tape that is larger is given back to the system.
const MOST_BYTES: usize = 1 << 30;

/// Runs `work` with a tape that the thread keeps. If that panics, the tape is dropped.
pub(crate) fn with_tape<R: Real, T>(work: impl FnOnce(&mut Tape<R>) -> T) -> T {
    keeping(MOST_BYTES, work)
}

fn keeping<R: Real, T>(most: usize, work: impl FnOnce(&mut Tape<R>) -> T) -> T {
    let mut tape = pool::take::<Tape<R>>().unwrap_or_default();
    let result = work(&mut tape);
    // Fused entries may own what belongs to the caller.
    tape.forget();
    if tape.bytes() <= most {
        pool::keep(tape);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::{MOST_BYTES, keeping, with_tape};
    use crate::pool::count;
    use crate::reverse::{Tape, Var};
    use crate::{Dual, gradient_of};

    fn long(x: Var<f64>, entries: usize) -> Var<f64> {
        (0..entries).fold(x, |y, _| y * x)
    }

    #[test]
    #[cfg_attr(target_family = "wasm", ignore = "no threads: tests share one")]
    fn a_thread_keeps_one_tape_of_a_type() {
        let capacity = |tape: &mut Tape<f64>| tape.bytes();
        assert_eq!(with_tape(capacity), 0);
        assert_eq!(gradient_of(|x| long(x[0], 1000), &[1.0]), [1001.0]);
        let kept = with_tape(capacity);
        assert!(kept >= 24 * 1000);
        with_tape(|_: &mut Tape<Dual<f64, 2>>| {
            with_tape(|_: &mut Tape<f32>| assert_eq!(count(), 1))
        });
        assert_eq!((count(), with_tape(capacity)), (3, kept));
    }

    #[test]
    #[cfg_attr(panic = "abort", ignore = "panics do not unwind")]
    fn a_tape_that_was_left_in_a_panic_is_not_used_again() {
        let left =
            std::panic::catch_unwind(|| gradient_of(|_: &[Var<f64>]| panic!("left"), &[1.0]));
        assert!(left.is_err());
        assert_eq!(gradient_of(|x| x[0] * x[0], &[3.0]), [6.0]);
    }

    #[test]
    fn what_is_large_goes_back_to_the_system() {
        let record = |tape: &mut Tape<f64>| tape.record(&[1.0], |x| long(x[0], 1000)).value();
        assert_eq!(keeping(24 * 1000, record), 1.0);
        assert_eq!(count(), 0);
        assert_eq!(keeping(MOST_BYTES, record), 1.0);
        assert_eq!(count(), 1);
    }
}
