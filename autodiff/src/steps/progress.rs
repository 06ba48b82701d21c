//! The step that is running. [`trace`](crate::trace) reports in which step a NaN arose.

use std::cell::RefCell;

use crate::restored::Restored;

thread_local! {
    static STEP: RefCell<Option<usize>> = const { RefCell::new(None) };
}

/// The step of the innermost rollout that runs on this thread, or `None` outside of rollouts.
pub(crate) fn step() -> Option<usize> {
    STEP.with_borrow(|step| *step)
}

pub(super) fn begin_step(step: usize) {
    STEP.set(Some(step));
}

/// Marks the run of a rollout. When it ends, the step of the enclosing rollout is current again.
pub(super) fn running() -> Restored<Option<usize>> {
    Restored::set(&STEP, step())
}
