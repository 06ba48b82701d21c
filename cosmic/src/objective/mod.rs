//! From a trajectory to a loss, from a mixture to its measures, and from both to the objective.

mod augmented;
mod displacement;
mod measures;
mod tasks;

pub use augmented::{AugmentedLagrangian, violations};
pub use displacement::Displacement;
pub use measures::{Measures, measures};
pub use tasks::{Climb, Economy, Objective, Reach};

use autodiff::Real;

use crate::simulator::Trajectory;

/// A number to be made small, from states of a rollout.
///
/// Written once over [`Real`], it is differentiated by the engine; there is no adjoint to write.
pub trait Loss {
    /// Which states it looks at in a rollout of so many steps: numbers of steps done, ascending,
    /// the last of them `steps`.
    fn observed(&self, steps: usize) -> Vec<usize>;

    /// How many nodes of these states it looks at, from the first on, which carries the payload;
    /// states that a gradient is taken through hold no others. All, unless it says otherwise.
    fn nodes(&self) -> usize {
        usize::MAX
    }

    /// The loss of a trajectory that holds at least the states and nodes observed.
    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R;
}
