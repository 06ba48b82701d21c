//! Which step is running, for [`trace`](crate::trace), which says in which step a NaN arose.

use std::cell::RefCell;

use crate::restored::Restored;

thread_local! {
    static STEP: RefCell<Option<usize>> = const { RefCell::new(None) };
}

/// The step of the innermost rollout that runs on this thread; `None` outside of rollouts.
pub(crate) fn step() -> Option<usize> {
    STEP.with_borrow(|step| *step)
}

pub(super) fn begin_step(step: usize) {
    STEP.set(Some(step));
}

/// A run of a rollout: when it ends, the step of the rollout around it is back.
pub(super) fn running() -> Restored<Option<usize>> {
    Restored::set(&STEP, step())
}
