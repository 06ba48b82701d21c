//! Keeps track of the step that is running, so that [`trace`](crate::trace) can report in which step a NaN arose.

use std::cell::RefCell;

use crate::restored::Restored;

thread_local! {
    static STEP: RefCell<Option<usize>> = const { RefCell::new(None) };
}

/// Returns the step of the innermost rollout that runs on this thread, or `None` outside of rollouts.
pub(crate) fn step() -> Option<usize> {
    STEP.with_borrow(|step| *step)
}

pub(super) fn begin_step(step: usize) {
    STEP.set(Some(step));
}

/// Call this at the start of a rollout. When the result is dropped, the step of the enclosing rollout becomes current
/// again.
pub(super) fn running() -> Restored<Option<usize>> {
    Restored::set(&STEP, step())
}
