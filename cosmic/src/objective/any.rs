//! A loss behind a pointer, and those that scenes choose by name.
//!
//! An optimisation evaluates its loss in four number types, a gradient check in a fifth. Through a pointer,
//! a user's loss is compiled for these in the user's crate, and the simulator only in this one: it is not
//! compiled again for every loss, nor without optimisation where the user's crate is.

use std::sync::Arc;

use autodiff::{Dual, Real, Var};

use super::{Loss, Objective};
use crate::registry::Registry;
use crate::scene::{OwnLoss, Scene};
use crate::simulator::Trajectory;

/// The loss of trajectories of one number type.
pub trait LossOf<R> {
    /// The loss of a trajectory.
    fn loss_of(&self, trajectory: &Trajectory<R>) -> R;
}

impl<L: Loss, R: Real> LossOf<R> for L {
    fn loss_of(&self, trajectory: &Trajectory<R>) -> R {
        self.loss(trajectory)
    }
}

/// Any [`Loss`], in all five number types.
pub trait AnyLoss:
    Loss + LossOf<f64> + LossOf<f32> + LossOf<Var<f64>> + LossOf<Var<f32>> + LossOf<Dual<f64, 1>>
{
}

impl<L: Loss> AnyLoss for L {}

/// The losses that scenes may choose, by their names.
static LOSSES: Registry<Arc<dyn AnyLoss>> = Registry::new();

/// Makes a loss known to all scenes that this process reads from now on, which choose it by
/// `objective.own_loss = "its_name"`.
///
/// # Panics
/// If the name is taken.
pub fn add(name: &'static str, loss: impl Loss + 'static) {
    OwnLoss::add(name);
    LOSSES.add("loss", name, Arc::new(loss));
}

/// The loss of a scene: that of its task, or the one it names.
pub fn of_scene(scene: &Scene) -> Arc<dyn AnyLoss> {
    let own = scene.objective.own_loss.name();
    own.and_then(|name| LOSSES.get(name)).unwrap_or_else(|| {
        Arc::new(Objective::new(
            &scene.objective,
            &scene.loss,
            &scene.physics,
        ))
    })
}
