//! The step that is running, for code that runs many steps.

use std::cell::RefCell;

use crate::restored::Restored;

thread_local! {
    static STEP: RefCell<Option<usize>> = const { RefCell::new(None) };
}

/// Returns the step of the innermost run on this thread, or `None` outside of runs.
pub(super) fn step() -> Option<usize> {
    STEP.with_borrow(|step| *step)
}

/// Call this at the start of each step.
#[inline]
pub fn begin_step(step: usize) {
    STEP.set(Some(step));
}

/// Call this at the start of a run. When the result is dropped, the step of the enclosing run becomes current again.
pub fn running() -> Restored<Option<usize>> {
    Restored::set(&STEP, step())
}
