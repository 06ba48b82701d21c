//! A loss behind a pointer.
//!
//! An optimisation evaluates its loss in four number types. Through a pointer, a user's loss is
//! compiled for these four in the user's crate, and the simulator only in this one: it is not
//! compiled again for every loss, nor without optimisation where the user's crate is.

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

/// Any [`Loss`], in all four number types.
pub(crate) trait AnyLoss:
    Loss + LossOf<f64> + LossOf<f32> + LossOf<Var<f64>> + LossOf<Var<f32>>
{
}

impl<L: Loss> AnyLoss for L {}
