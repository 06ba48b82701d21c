//! A loss behind a pointer.
//!
//! An optimisation evaluates its loss in four number types. Through a pointer, a loss of one's own
//! is compiled for these four in its own crate, and the simulator in this one alone: no loss has
//! the simulator compiled again, or left slow in a crate that is built without optimisation.

use autodiff::{Real, Var};

use super::Loss;
use crate::simulator::Trajectory;

/// The loss of trajectories of one number type.
pub(crate) trait LossOf<R> {
    fn loss_of(&self, trajectory: &Trajectory<R>) -> R;
}

impl<L: Loss, R: Real> LossOf<R> for L {
    fn loss_of(&self, trajectory: &Trajectory<R>) -> R {
        self.loss(trajectory)
    }
}

/// A [`Loss`], whichever.
pub(crate) trait AnyLoss:
    LossOf<f64> + LossOf<f32> + LossOf<Var<f64>> + LossOf<Var<f32>> + Send + Sync
{
    fn observed(&self, steps: usize) -> Vec<usize>;
    fn nodes(&self) -> usize;
    fn is_far(&self) -> bool;
}

impl<L: Loss> AnyLoss for L {
    fn observed(&self, steps: usize) -> Vec<usize> {
        Loss::observed(self, steps)
    }

    fn nodes(&self) -> usize {
        Loss::nodes(self)
    }

    fn is_far(&self) -> bool {
        Loss::is_far(self)
    }
}
