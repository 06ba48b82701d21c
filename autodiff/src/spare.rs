//! Memory that a thread is done with, for its next recording or sweep: to have fresh pages from the
//! system costs as much as a good part of the work does.

use std::any::Any;
use std::cell::RefCell;

/// One piece of a type each; with nested modes there are a few types.
const MOST: usize = 6;

thread_local! {
    static SPARE: RefCell<Vec<Box<dyn Any>>> = const { RefCell::new(Vec::new()) };
}

fn take_from<T: Any>(spare: &mut Vec<Box<dyn Any>>) -> Option<Box<T>> {
    let place = spare.iter().position(|piece| piece.is::<T>())?;
    spare.swap_remove(place).downcast().ok()
}

/// What the thread kept of a type.
pub(crate) fn take<T: Any>() -> Option<Box<T>> {
    // At the end of a thread there is nothing left, nor a place for it.
    let taken = SPARE.try_with(|spare| take_from(&mut spare.borrow_mut()));
    taken.ok().flatten()
}

/// Keeps something in place of what was kept of its type. It must hold nothing of the caller's.
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
