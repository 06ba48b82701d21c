//! Losses behind a pointer (trait objects), and the choice of a loss by its name in a scene.
//!
//! An optimisation evaluates its loss in four number types, a gradient check in two more. If the loss is behind a
//! pointer, the user's crate compiles only the loss for these types, and this crate compiles the simulator. So the
//! simulator is not compiled again for every loss, and it is optimised even if the user's crate is not.

use std::sync::Arc;

use autodiff::{DoubleDouble, Dual, Real, Var};

use super::{Errand, Loss, Objective};
use crate::registry::Registry;
use crate::scene::{GoalKind, ItemName, Scene, TaskKind};
use crate::world::{Robot, Span, Trajectory, World};

/// A loss for trajectories whose numbers have the type `R`. Unlike [`Loss`], it can be a trait object.
pub trait LossOf<R> {
    /// Computes the loss of a trajectory.
    fn loss_of(&self, trajectory: &Trajectory<R>) -> R;
}

impl<L: Loss, R: Real> LossOf<R> for L {
    fn loss_of(&self, trajectory: &Trajectory<R>) -> R {
        self.loss(trajectory)
    }
}

/// A [`Loss`] as a trait object. It can be computed in each of the six number types that this crate uses.
pub trait AnyLoss:
    Loss
    + LossOf<f64>
    + LossOf<f32>
    + LossOf<Var<f64>>
    + LossOf<Var<f32>>
    + LossOf<Dual<f64, 1>>
    + LossOf<DoubleDouble>
{
}

impl<L: Loss> AnyLoss for L {}

impl Registry {
    /// Adds a loss. Scenes choose it by `objective.own_loss = "its_name"`.
    ///
    /// # Panics
    /// If the name is taken.
    #[must_use]
    pub fn with_loss(self, name: &'static str, loss: impl Loss + 'static) -> Self {
        let loss: Arc<dyn AnyLoss> = Arc::new(loss);
        self.with(ItemName::LOSS, &[], name, loss)
    }
}

/// Simulates robots. The trajectories hold the states and the nodes that the loss reads. `span` says when the walks begin and
/// end.
///
/// # Panics
/// Like [`World::run`].
pub fn walks<R: Real>(
    world: &World,
    robots: &[Robot<R>],
    loss: &(impl Loss + ?Sized),
    span: &Span,
) -> Vec<Trajectory<R>> {
    let of_markers = robots.iter().map(|robot| robot.body.marker.nodes());
    let steps = span.steps().min(world.physics().steps);
    let span = Span {
        nodes: of_markers.fold(loss.nodes(), usize::max),
        metered: loss.reads_efforts(),
        ..span.observing(loss.observed(steps))
    };
    world.run(robots, &span)
}

/// Simulates a robot and returns its loss; see [`walks`].
///
/// # Panics
/// Like [`World::run`].
pub fn loss_of<R: Real>(
    world: &World,
    robot: &Robot<R>,
    loss: &(impl Loss + LossOf<R> + ?Sized),
    span: &Span,
) -> R {
    let walks = walks(world, std::slice::from_ref(robot), loss, span);
    loss.loss_of(&walks[0])
}

/// The loss that a scene names; if it names none, the loss of the scene's task.
pub fn of_scene(scene: &Scene) -> Arc<dyn AnyLoss> {
    let own = scene.objective.own_loss.item::<Arc<dyn AnyLoss>>();
    own.cloned().unwrap_or_else(|| {
        if scene.controller.goals == GoalKind::Given && scene.objective.task == TaskKind::Reach {
            return Arc::new(Errand::of_scene(scene));
        }
        Arc::new(Objective::of_scene(scene))
    })
}

/// The share of a window, at its end, in which the loss counts.
const COUNTS: f64 = 0.5;

/// The number of states that the loss reads in a window.
const READS: usize = 16;

/// The loss of a scene over a window of `steps` steps of a walk.
pub(crate) fn of_window(scene: &Scene, steps: usize) -> Arc<dyn AnyLoss> {
    let mut short = scene.clone();
    short.loss.window = ((COUNTS * steps as f64) as usize).max(1);
    short.loss.every = (short.loss.window / READS).max(1);
    if scene.objective.task == TaskKind::Economy {
        // The energy is that of the whole window, but a robot that keeps its speed has done this share of the way in the
        // mean over the states that count.
        short.objective.weight *= 1.0 - 0.5 * COUNTS;
    }
    of_scene(&short)
}
