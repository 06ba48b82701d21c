//! The formula of a kernel, in a file that both the program and its build script include.

use autodiff::{Real, lit};

/// A kernel for one step of a body that falls through air.
#[derive(Clone)]
pub(crate) struct Drag {
    pub(crate) dt: f64,
}

impl Drag {
    /// Computes the velocity after a step from the velocity before it, the drag and the gravity.
    #[inline(always)]
    pub(crate) fn decelerated<R: Real>(&self, [v, drag, gravity]: [R; 3]) -> [R; 1] {
        [v + lit(self.dt) * (gravity - drag * v * v.tanh())]
    }
}
