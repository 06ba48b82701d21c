//! Memory that a thread is done with, for its next recording or sweep: fresh pages from the system
//! would cost a good part of what the work itself does.

use std::any::Any;
use std::cell::RefCell;

/// At most one piece of each type; nested modes use a few types.
const MOST: usize = 6;

thread_local! {
    static SPARE: RefCell<Vec<Box<dyn Any>>> = const { RefCell::new(Vec::new()) };
}

fn take_from<T: Any>(spare: &mut Vec<Box<dyn Any>>) -> Option<Box<T>> {
    let place = spare.iter().position(|piece| piece.is::<T>())?;
    spare.swap_remove(place).downcast().ok()
}

/// What the thread has kept of this type, if anything.
pub(crate) fn take<T: Any>() -> Option<Box<T>> {
    // While a thread ends, its thread-locals may be gone already; so below.
    let taken = SPARE.try_with(|spare| take_from(&mut spare.borrow_mut()));
    taken.ok().flatten()
}

/// Keeps a piece in place of an earlier one of its type. It must hold nothing of the caller's, whose
/// destructor would run late.
pub(crate) fn keep<T: Any>(piece: Box<T>) {
    let _ = SPARE.try_with(|spare| {
        let mut spare = spare.borrow_mut();
        take_from::<T>(&mut spare);
        spare.truncate(MOST - 1);
        spare.insert(0, piece);
    });
}

/// How many pieces the thread keeps.
#[cfg(test)]
pub(crate) fn count() -> usize {
    SPARE.with_borrow(Vec::len)
}
