//! The trait of losses.

use autodiff::Real;

use crate::simulator::Trajectory;

/// A number to be made small, from states of a rollout.
///
/// Written once over [`Real`], it is differentiated by the engine; there is no adjoint to write.
/// Robots are designed for it by [`CoDesign::with_loss`](crate::codesign::CoDesign::with_loss),
/// side by side on several threads. `cosmic_lab::verify::check_gradients_of` tells whether its
/// gradient is the derivative of its values: a `floor`, or a branch on a value, may have changed it.
pub trait Loss: Send + Sync {
    /// Which states it looks at in a rollout of so many steps: numbers of steps done, ascending,
    /// the last of them `steps`.
    fn observed(&self, steps: usize) -> Vec<usize>;

    /// How many nodes of these states it looks at, from the first on, which carries the payload;
    /// states that a gradient is taken through hold no others. All, unless it says otherwise.
    fn nodes(&self) -> usize {
        usize::MAX
    }

    /// Whether robots are ranked by how far they get along the ground, as in the paper. Unless a
    /// loss says so, they are ranked by minus this loss of a full rollout.
    fn is_far(&self) -> bool {
        false
    }

    /// The loss of a trajectory that holds at least the states and nodes observed.
    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R
    where
        Self: Sized;
}
