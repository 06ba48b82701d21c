//! How far a robot gets in a full rollout, and how well it does its task.

use super::{CoDesign, Progress};
use crate::controller::Controller;
use crate::gradient::Task;
use crate::lattice::State;
use crate::objective::Loss;
use crate::simulator::{Guarded, Span};

/// What came of a full rollout; NaN where it diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reached {
    /// Displacement of the payload along the ground, and in the height above, m.
    pub moved: [f64; 2],
    /// What designs are ranked by: the displacement along the ground, and for another task minus
    /// its loss.
    pub merit: f64,
}

impl Reached {
    pub(super) fn along(&self) -> f64 {
        self.moved[0]
    }
}

impl CoDesign {
    /// A full rollout of the robot as it stands.
    pub(super) fn evaluate(&self, progress: &Progress) -> Reached {
        let mixture = self.mixture(progress);
        self.reach(&mixture, &progress.controller, (&self.task, &self.start))
    }

    /// A full rollout of a robot in a world.
    pub fn reach(
        &self,
        mixture: &[[f64; 3]],
        controller: &Controller<f64>,
        (task, start): (&Task, &State<f64>),
    ) -> Reached {
        self.reach_many(&[mixture], controller, (task, &[start]))[0]
    }

    /// The same from several starts, all of one robot or each of its own.
    pub fn reach_many(
        &self,
        mixtures: &[&[[f64; 3]]],
        controller: &Controller<f64>,
        (task, starts): (&Task, &[&State<f64>]),
    ) -> Vec<Reached> {
        let steps = task.physics.steps;
        let far = self.objective.is_far();
        let observed = match far {
            true => vec![steps],
            false => self.objective.observed(steps),
        };
        let span = Span::from_start(observed);
        let all = task.guarded_many(mixtures, (controller, starts), &span);
        let reached = |(&start, guarded): (&&State<f64>, &Guarded)| {
            let moved = self.moved(start, guarded);
            let merit = match far || moved[0].is_nan() {
                true => moved[0],
                false => -self.objective.loss(&guarded.trajectory),
            };
            Reached { moved, merit }
        };
        starts.iter().zip(&all).map(reached).collect()
    }

    /// From the payload's start to its place in the last state, in the ground's frame; NaN where
    /// any state is absurd.
    pub(super) fn moved(&self, start: &State<f64>, guarded: &Guarded) -> [f64; 2] {
        if guarded.divergence.is_some() {
            return [f64::NAN; 2];
        }
        let trajectory = &guarded.trajectory;
        self.between(start, trajectory.at(trajectory.last_step()))
    }

    /// From the payload's start to its place in another state, in the ground's frame; NaN where
    /// that state is absurd.
    pub(super) fn between(&self, start: &State<f64>, last: &State<f64>) -> [f64; 2] {
        if last.is_absurd() {
            return [f64::NAN; 2];
        }
        let ground = self.task.ground();
        let [from, to] = [start, last].map(|s| ground.point_to_ground(s.x[0]));
        [to[0] - from[0], to[1] - from[1]]
    }
}
