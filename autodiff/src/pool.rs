//! A pool of buffers, one per thread: a recording or a sweep takes the buffer of the last one. Fresh pages
//! from the system would cost as much as a good part of the work itself.

use std::any::Any;
use std::cell::RefCell;

/// The most buffers a thread keeps, one of each type; nested modes use a few types.
const MOST: usize = 6;

thread_local! {
    static POOL: RefCell<Vec<Box<dyn Any>>> = const { RefCell::new(Vec::new()) };
}

fn take_from<T: Any>(pool: &mut Vec<Box<dyn Any>>) -> Option<Box<T>> {
    let place = pool.iter().position(|buffer| buffer.is::<T>())?;
    pool.swap_remove(place).downcast().ok()
}

/// The thread's buffer of this type, if it has one.
pub(crate) fn take<T: Any>() -> Option<Box<T>> {
    // Thread-locals may be gone already while a thread ends, here and below.
    let taken = POOL.try_with(|pool| take_from(&mut pool.borrow_mut()));
    taken.ok().flatten()
}

/// Keeps a buffer in place of an earlier one of its type. It must hold nothing of the caller's: a
/// destructor would run late.
pub(crate) fn keep<T: Any>(buffer: Box<T>) {
    let _ = POOL.try_with(|pool| {
        let mut pool = pool.borrow_mut();
        take_from::<T>(&mut pool);
        pool.truncate(MOST - 1);
        pool.insert(0, buffer);
    });
}

/// How many buffers the thread keeps.
#[cfg(test)]
pub(crate) fn count() -> usize {
    POOL.with_borrow(Vec::len)
}
