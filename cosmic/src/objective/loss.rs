//! The trait that every loss implements.

use autodiff::Real;

use crate::world::Trajectory;

/// A number to minimise, computed from states of a rollout.
///
/// A loss is written once, for any number type [`Real`]. Its gradient is computed by automatic differentiation, so no
/// adjoint has to be written. [`CoDesign::with_loss`](crate::search::CoDesign::with_loss) designs robots that
/// minimise the loss, on several threads at once. `cosmic_lab::check::check_gradients_of` checks that the gradient is
/// the derivative of the values. A `floor` or a branch on a value can make the gradient wrong.
pub trait Loss: Send + Sync {
    /// The states that the loss reads in a rollout of `steps` steps: for each state, the number of steps after which it is
    /// reached (0 for the start). The numbers must ascend, and the last one must be `steps`.
    fn observed(&self, steps: usize) -> Vec<usize>;

    /// The number of nodes that the loss reads, beginning with node 0. When a gradient is computed, states hold only these
    /// nodes, and those that [`Trajectory::payload`] and [`Trajectory::position`] need. By default the loss reads all
    /// nodes.
    fn nodes(&self) -> usize {
        usize::MAX
    }

    /// True if the loss reads the [efforts](Trajectory::efforts) of the bars: activations, forces and work. A rollout
    /// computes them only if it is asked to. By default it is false.
    fn reads_efforts(&self) -> bool {
        false
    }

    /// True if robots are ranked by how far they get along the ground, as in the paper. By default it is false, and a
    /// robot is ranked by this loss of its full rollout: the smaller, the better.
    fn is_far(&self) -> bool {
        false
    }

    /// The loss that counts as 1 in the bounds on gradients and in the comparison with the constraints, for a lattice
    /// of this [scale](crate::lattice::Lattice::scale) (m). The losses of the tasks are lengths, so their unit is the
    /// scale. By default it is 1.
    fn unit(&self, _scale: f64) -> f64 {
        1.0
    }

    /// Computes the loss of a trajectory. The trajectory holds at least the states and nodes that the loss reads.
    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R
    where
        Self: Sized;
}
