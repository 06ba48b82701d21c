//! The loss for robots that go to the goals that they are given.

use std::collections::BTreeSet;
use std::ops::Range;

use autodiff::Real;

use super::Loss;
use crate::geometry::Ground;
use crate::scene::{GoalsSettings, LossSettings, Scene};
use crate::world::Trajectory;

/// The loss of the task "reach" if goals are inputs of a rollout: the share of the way to a goal that the robot has not
/// covered when the time of the goal ends, as a mean over the goals of a rollout. 0 means that the robot is at its goal and
/// stays there, 1 that it came no nearer.
///
/// The way to a goal is its distance from the goal before it, along the ground and in space also across. The way to the
/// first goal is its distance from the payload at the start of the rollout. The remaining way is the distance of the payload
/// from the goal, plus its speed along the ground multiplied by a time. It is a mean over the last `loss.window` steps of the
/// goal's time, at most half of this time, taken at every `loss.every`-th step.
#[derive(Clone, Debug, PartialEq)]
pub struct Errand {
    ground: Ground,
    settings: LossSettings,
    /// The time by which a speed is multiplied, s.
    settle: f64,
    /// The numbers of steps at which goals may change.
    changes: Vec<usize>,
}

impl Errand {
    /// The loss of a scene with the task "reach" and given goals.
    pub fn of_scene(scene: &Scene) -> Self {
        Self {
            ground: Ground::from(&scene.physics),
            settings: scene.loss.clone(),
            settle: scene.objective.settle(),
            changes: GoalsSettings::changes(scene.physics.steps).collect(),
        }
    }

    /// The numbers of steps after which the loss reads a state, for a goal that holds in these steps.
    fn read(&self, time: Range<usize>) -> impl Iterator<Item = usize> {
        let LossSettings { window, every, .. } = self.settings;
        let count = window.min(time.len() / 2).div_ceil(every).max(1);
        (0..count).rev().map(move |k| time.end - k * every)
    }
}

impl Loss for Errand {
    /// The start, the states for a single goal, and the states for goals that change at the same steps as those of the scene.
    fn observed(&self, steps: usize) -> Vec<usize> {
        let changes = self.changes.iter().copied().filter(|&step| step < steps);
        let changes: Vec<usize> = changes.collect();
        let from = [0].into_iter().chain(changes.iter().copied());
        let to = changes.iter().copied().chain([steps]);
        let times = from
            .zip(to)
            .map(|(from, to)| from..to)
            .chain(std::iter::once(0..steps));
        let read = times.flat_map(|time| self.read(time));
        let observed: BTreeSet<usize> = read.chain([0]).collect();
        observed.into_iter().collect()
    }

    fn nodes(&self) -> usize {
        1
    }

    fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
        let goals = trajectory.goals.as_ref();
        let goals = goals.expect("the task `reach` with given goals needs rollouts with goals");
        let dimension = trajectory.at(0).dimension;
        let mut before = self.ground.vector_to_ground(trajectory.position(0));
        let mut left = Vec::new();
        for (time, goal) in goals.times(trajectory.last_step()) {
            let place = |step: usize| self.ground.vector_to_ground(trajectory.position(step));
            let velocity = |step: usize| self.ground.vector_to_ground(trajectory.velocity(step));
            let settle = R::lit(self.settle);
            let off = |step: usize| {
                let speed = dimension.norm_along(velocity(step));
                dimension.norm_along(place(step) - goal) + speed * settle
            };
            let offs: Vec<R> = self.read(time).map(off).collect();
            let mean = R::sum_of(&offs) * R::lit(1.0 / offs.len() as f64);
            left.push(mean / dimension.norm_along(goal - before));
            before = goal;
        }
        R::sum_of(&left) * R::lit(1.0 / left.len() as f64)
    }
}
