//! The point at which an iteration computes its gradients, and the variations over which it averages them.

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use super::begin::CoDesign;
use super::progress::Progress;
use super::schedule::Schedule;
use super::slope::GradientPoint;
use crate::judge::{robots_of, with_goals};
use crate::random::{Purpose, stream_of};
use crate::scene::{GoalKind, GoalsSettings};
use crate::world::{Variation, draw_goal, draw_many, together};

/// After this number of passes without any gradient, the payload counts as stuck.
const PATIENCE: usize = 3;

impl CoDesign {
    /// The point at which an iteration computes its gradients: the current robot, the variations, and the horizon.
    pub fn point(&self, progress: &Progress, now: &Schedule) -> GradientPoint {
        let (first, variations) = self.variations(progress, now);
        GradientPoint {
            variations,
            inputs: self.inputs(progress),
            horizon: self.evaluator.horizon(now, first),
            sticks: progress.flat >= PATIENCE,
        }
    }

    /// The variations over which an iteration averages its gradients, and the number of steps on the clock at their starts.
    /// Empty for a scene without domain randomisation (`[robust]`) and without given goals. They depend only on the robot,
    /// the seed and the iteration, so that a resumed run draws the same variations.
    pub fn variations(&self, progress: &Progress, now: &Schedule) -> (usize, Vec<Variation>) {
        let scene = self.scene();
        let (robust, goals) = (&scene.robust, scene.controller.goals);
        let number = now.iteration as u64;
        let stream = |purpose| stream_of(progress.seed, purpose, number);
        let count = match goals {
            GoalKind::Fixed => robust.samples,
            GoalKind::Given => GoalsSettings::SAMPLES,
        };
        let variations = match robust.samples {
            0 => vec![self.evaluator.nominal(); count],
            _ => {
                let stream = stream(Purpose::DomainRandomisation);
                draw_many(self.world(), &robust.scatter(), count, stream)
            }
        };
        match goals {
            GoalKind::Fixed => (0, variations),
            GoalKind::Given => {
                let rest = self.scene().physics.steps.saturating_sub(now.horizon());
                self.with_a_goal(variations, progress, rest, stream(Purpose::Goals))
            }
        }
    }

    /// These variations, each with one goal: half of the goals are ahead, half behind. In one of
    /// [`COUNT`](GoalsSettings::COUNT) iterations, robots begin at rest, as in a sequence of goals. In the others they
    /// are on their way to a goal before, for the number of steps that is returned, at most `rest`.
    fn with_a_goal(
        &self,
        variations: Vec<Variation>,
        progress: &Progress,
        rest: usize,
        mut stream: ChaCha8Rng,
    ) -> (usize, Vec<Variation>) {
        let goals = &self.scene().goals;
        let whole = (self.scene().physics.steps / GoalsSettings::COUNT).min(rest);
        let steps = match progress.iteration % GoalsSettings::COUNT {
            0 => 0,
            _ => stream.random_range(whole / 2..=whole),
        };
        let mut with_one = |variations: Vec<Variation>, in_turn: usize| {
            with_goals(variations, |k, variation| {
                let ahead = (k / in_turn).is_multiple_of(2);
                draw_goal(self.world(), &variation.start, goals, ahead, &mut stream)
            })
        };
        let mut variations = with_one(variations, 1);
        if steps == 0 {
            return (0, variations);
        }
        let (design, controller) = (self.design(progress), &progress.controller);
        let precision = self.scene().gradient.precision;
        let walk = |variations: &[Variation]| {
            let robots = robots_of(&design, variations);
            self.evaluator
                .watched(&robots, controller, vec![steps], precision)
        };
        let chunks = variations.par_chunks(together(variations.len()));
        let walked: Vec<_> = chunks.flat_map_iter(walk).collect();
        for (variation, walked) in variations.iter_mut().zip(walked) {
            if let Some(mut walked) = walked {
                variation.start = walked.states.remove(0);
            }
        }
        // The goals ahead and behind follow goals ahead and behind equally often.
        (steps, with_one(variations, 2))
    }
}
