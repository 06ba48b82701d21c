//! Keeps used buffers for each thread. A recording or a sweep reuses the buffer of the last one, because the time that
//! the system takes for fresh memory pages would be a large part of the whole time.

use std::any::Any;
use std::cell::RefCell;

/// The largest number of buffers that a thread keeps. It keeps at most one buffer of each type, and even nested modes
/// use only a few types.
const MOST: usize = 6;
/// The largest number of bytes that a thread keeps in all buffers together, until it ends.
pub const MOST_BYTES: usize = 1 << 30;

/// A buffer that a thread may keep. It must not own data of the caller, because their destructors would run too late.
pub trait Pooled: Any {
    /// The number of bytes that the buffer has allocated.
    fn bytes(&self) -> usize;
}

/// The buffers that a thread keeps, with the most recently used one first.
struct Pool(Vec<Box<dyn Pooled>>);

thread_local! {
    static POOL: RefCell<Pool> = const { RefCell::new(Pool(Vec::new())) };
}

impl Pool {
    fn take<T: Pooled>(&mut self) -> Option<Box<T>> {
        let mut buffers = self.0.iter();
        let place = buffers.position(|buffer| (&**buffer as &dyn Any).is::<T>())?;
        let buffer: Box<dyn Any> = self.0.remove(place);
        buffer.downcast().ok()
    }

    /// Keeps a buffer unless it alone is too large. Drops the least recently used buffers if all together are too
    /// large.
    fn keep<T: Pooled>(&mut self, buffer: Box<T>) {
        self.take::<T>();
        if buffer.bytes() > MOST_BYTES {
            return;
        }
        self.0.insert(0, buffer);
        let mut bytes = 0;
        let fitting = self.0.iter().take_while(|buffer| {
            bytes += buffer.bytes();
            bytes <= MOST_BYTES
        });
        let fitting = fitting.count();
        self.0.truncate(fitting.min(MOST));
    }
}

/// Takes the thread's buffer of this type out of the pool, if there is one.
pub fn take<T: Pooled>() -> Option<Box<T>> {
    // `try_with` is used here and below, because the pool may already be destroyed while its thread ends.
    let taken = POOL.try_with(|pool| pool.borrow_mut().take());
    taken.ok().flatten()
}

/// Puts a buffer into the pool, unless it is too large. It replaces the earlier buffer of its type.
pub fn keep<T: Pooled>(buffer: Box<T>) {
    let _ = POOL.try_with(|pool| pool.borrow_mut().keep(buffer));
}
