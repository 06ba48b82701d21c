//! Which step is running, for [`trace`](crate::trace), which says in which step a NaN arose.

use std::cell::Cell;

thread_local! {
    static STEP: Cell<Option<usize>> = const { Cell::new(None) };
}

/// The step of the innermost rollout that runs on this thread; `None` outside of rollouts.
pub(crate) fn step() -> Option<usize> {
    STEP.get()
}

pub(super) fn begin_step(step: usize) {
    STEP.set(Some(step));
}

/// A run of a rollout. When it ends, also by a panic, the step of the rollout around it is back.
pub(super) struct Running {
    outer: Option<usize>,
}

impl Running {
    pub(super) fn start() -> Self {
        Self { outer: STEP.get() }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        STEP.set(self.outer);
    }
}
