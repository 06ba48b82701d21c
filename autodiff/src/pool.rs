//! Keeps used buffers for each thread. A recording or a sweep reuses the buffer of the last one, because the time that
//! the system takes for fresh memory pages would be a large part of the whole time.

use std::any::Any;
use std::cell::RefCell;

/// The largest number of buffers that a thread keeps. It keeps at most one buffer of each type, and even nested modes
/// use only a few types.
const MOST: usize = 6;
/// The largest number of bytes that a thread keeps in all buffers together.
const MOST_BYTES: usize = 1 << 30;

/// A buffer that a thread may keep. It must not own data of the caller, because their destructors would run too late.
pub(crate) trait Pooled: Any {
    /// The number of bytes that the buffer has allocated.
    fn bytes(&self) -> usize;
}

/// The buffers that a thread keeps, with the most recently used one first.
struct Pool {
    buffers: Vec<Box<dyn Pooled>>,
    most_bytes: usize,
}

thread_local! {
    static POOL: RefCell<Pool> = const {
        RefCell::new(Pool {
            buffers: Vec::new(),
            most_bytes: MOST_BYTES,
        })
    };
}

impl Pool {
    fn take<T: Pooled>(&mut self) -> Option<Box<T>> {
        let mut buffers = self.buffers.iter();
        let place = buffers.position(|buffer| (&**buffer as &dyn Any).is::<T>())?;
        let buffer: Box<dyn Any> = self.buffers.remove(place);
        buffer.downcast().ok()
    }

    /// Keeps a buffer unless it alone is too large. Drops the least recently used buffers if all together are too
    /// large.
    fn keep<T: Pooled>(&mut self, buffer: Box<T>) {
        self.take::<T>();
        if buffer.bytes() > self.most_bytes {
            return;
        }
        self.buffers.insert(0, buffer);
        let mut bytes = 0;
        let fitting = self.buffers.iter().take_while(|buffer| {
            bytes += buffer.bytes();
            bytes <= self.most_bytes
        });
        let fitting = fitting.count();
        self.buffers.truncate(fitting.min(MOST));
    }
}

/// Takes the thread's buffer of this type out of the pool, if there is one.
pub(crate) fn take<T: Pooled>() -> Option<Box<T>> {
    // `try_with` is used here and below, because the pool may already be destroyed while its thread ends.
    let taken = POOL.try_with(|pool| pool.borrow_mut().take());
    taken.ok().flatten()
}

/// Puts a buffer into the pool, unless it is too large. It replaces the earlier buffer of its type.
pub(crate) fn keep<T: Pooled>(buffer: Box<T>) {
    let _ = POOL.try_with(|pool| pool.borrow_mut().keep(buffer));
}

/// The number of buffers in the thread's pool.
#[cfg(test)]
pub(crate) fn count() -> usize {
    POOL.with_borrow(|pool| pool.buffers.len())
}

#[cfg(test)]
mod tests {
    use super::{MOST, POOL, Pool, Pooled, count};
    use crate::data::{Sum, Summand};
    use crate::{Kernel, Memory, Model, Program, Real, Rollout, Var, gradient, kernel};

    /// A buffer that pretends to have this number of bytes. Different values of `TYPE` make different types.
    struct Bytes<const TYPE: usize>(usize);

    impl<const TYPE: usize> Pooled for Bytes<TYPE> {
        fn bytes(&self) -> usize {
            self.0
        }
    }

    fn total(pool: &Pool) -> usize {
        pool.buffers.iter().map(|buffer| buffer.bytes()).sum()
    }

    #[test]
    fn buffers_of_all_types_share_a_bound() {
        let mut pool = Pool {
            buffers: Vec::new(),
            most_bytes: 100,
        };
        pool.keep(Box::new(Bytes::<0>(60)));
        pool.keep(Box::new(Bytes::<1>(40)));
        assert_eq!((pool.buffers.len(), total(&pool)), (2, 100));
        // A buffer replaces another buffer of its type. If there are too many bytes, the oldest buffer is dropped.
        pool.keep(Box::new(Bytes::<1>(30)));
        assert_eq!((pool.buffers.len(), total(&pool)), (2, 90));
        pool.keep(Box::new(Bytes::<2>(50)));
        assert_eq!((pool.buffers.len(), total(&pool)), (2, 80));
        assert!(pool.take::<Bytes<0>>().is_none());
        // A buffer that is too large is dropped; the other buffers stay.
        pool.keep(Box::new(Bytes::<3>(101)));
        assert_eq!(total(&pool), 80);
        pool.keep(Box::new(Bytes::<1>(101)));
        assert_eq!(total(&pool), 50);
    }

    #[test]
    fn a_thread_keeps_few_buffers() {
        let mut pool = Pool {
            buffers: Vec::new(),
            most_bytes: 100,
        };
        fn keep<const TYPE: usize>(pool: &mut Pool) {
            pool.keep(Box::new(Bytes::<TYPE>(1)));
        }
        let each = [
            keep::<0>, keep::<1>, keep::<2>, keep::<3>, keep::<4>, keep::<5>, keep::<6>,
        ];
        each.iter().for_each(|keep| keep(&mut pool));
        assert_eq!(pool.buffers.len(), MOST);
        assert!(pool.take::<Bytes<0>>().is_none() && pool.take::<Bytes<6>>().is_some());
    }

    /// A kernel that halves a number.
    #[derive(Clone)]
    struct Half;

    #[kernel]
    impl Kernel<1, 1> for Half {
        fn eval<R: Real>(&self, [x]: [R; 1], _: &[R]) -> [R; 1] {
            [R::lit(0.5) * x]
        }
    }

    impl Model for Half {
        fn record(&self, program: &mut Program) {
            let x = program.state(1);
            let [half] = program.map(Half, [x], &[]);
            program.advance(x, half);
        }
    }

    /// A summand: the sum of the parameters times the datum.
    #[derive(Clone)]
    struct Line;

    impl Summand for Line {
        fn eval<R: Real>(&self, shared: &[R], datum: &[R]) -> R {
            let sum = shared.iter().fold(R::zero(), |sum, &x| sum + x);
            sum * datum[0]
        }
    }

    /// Runs each kind of work that keeps a buffer. Each buffer has at least `numbers` numbers.
    fn work_of_every_kind(numbers: usize) {
        let rollout = Rollout {
            memory: Memory::All,
            ..Rollout::new(Half, numbers)
        };
        assert!(gradient(|x| rollout.run(x, &[])[0], &[1.0])[0] >= 0.0);
        assert!(gradient(|x| rollout.run(x, &[])[0], &[1.0f32])[0] >= 0.0);
        let sum = Sum::new(Line, &[[1.0], [2.0]]);
        assert_eq!(gradient(|x| sum.run(x), &vec![1.0; numbers])[0], 3.0);
        let power = |x: &[Var<f64>]| (0..numbers).fold(x[0], |y, _| y * x[0]);
        assert_eq!(gradient(power, &[1.0]), [numbers as f64 + 1.0]);
        // Makes entries of selections and sums, whose operands are stored in a separate list.
        let least = |x: &[Var<f32>]| (0..numbers).fold(x[0], |y, _| y.min(x[0]));
        assert_eq!(gradient(least, &[1.0]), [1.0]);
    }

    #[test]
    #[cfg_attr(target_family = "wasm", ignore = "no threads: tests share one")]
    fn tapes_rollouts_and_sums_keep_to_the_bound() {
        work_of_every_kind(1000);
        let (kept, unbounded) = POOL.with_borrow(|pool| (count(), total(pool)));
        // The pool keeps tapes and rows in two precisions, and the numbers of the sum.
        assert!(kept >= 5 && unbounded > 5 * 8 * 1000, "{kept}, {unbounded}");
        let most = unbounded / 3;
        POOL.with_borrow_mut(|pool| pool.most_bytes = most);
        work_of_every_kind(1000);
        let bounded = POOL.with_borrow(total);
        assert!(0 < bounded && bounded <= most, "{bounded} of {most} bytes");
        // Buffers of longer work are freed.
        work_of_every_kind(100_000);
        assert!(POOL.with_borrow(total) <= most);
    }
}
