//! The formula of a kernel, which the build script includes too.

use autodiff::{Real, lit};

/// A step of a falling body in air.
#[derive(Clone)]
pub(crate) struct Drag {
    pub(crate) dt: f64,
}

impl Drag {
    /// The velocity after a step, from the velocity before, the drag and the gravity.
    #[inline(always)]
    pub(crate) fn decelerated<R: Real>(&self, [v, drag, gravity]: [R; 3]) -> [R; 1] {
        [v + lit(self.dt) * (gravity - drag * v * v.tanh())]
    }
}
