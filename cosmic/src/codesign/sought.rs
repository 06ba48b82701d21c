//! What a gradient of the displacement loss is taken by.

use autodiff::Real;

use crate::gradient::{CONTROLLER, DESIGN, Task};
use crate::projection::Projection;

/// What a gradient is taken by.
pub(super) enum Sought<'a> {
    /// The design, in a projection.
    Design(Projection),
    /// The shares of the materials, which one-hot design vectors are themselves (D7).
    Shares,
    /// The controller of a robot of this mixture.
    Controller(&'a [[f64; 3]]),
}

impl Sought<'_> {
    pub(super) fn blocks(&self) -> [bool; 7] {
        match self {
            Self::Design(_) | Self::Shares => DESIGN,
            Self::Controller(_) => CONTROLLER,
        }
    }

    /// The robot's mixture.
    pub(super) fn mixture<R: Real>(&self, task: &Task, z: &[[R; 3]]) -> Vec<[R; 3]> {
        match self {
            Self::Design(projection) => task.mixture(*projection, z),
            Self::Shares => z.to_vec(),
            Self::Controller(mixture) => mixture.iter().map(|m| m.map(R::lit)).collect(),
        }
    }
}
