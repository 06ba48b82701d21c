//! A controller learns in windows: the fine-tuning of scenes with `schedule.window`.

use rayon::prelude::*;

use super::begin::CoDesign;
use super::passes::note_displacement;
use super::progress::{Progress, Record};
use super::schedule::Schedule;
use super::slope::Slope;
use super::slopes::Variables;
use super::windows::{Learner, Walkers, Window};
use crate::design::{Design, Mixture};
use crate::inputs::Inputs;
use crate::judge::{Reached, VARIED};
use crate::lattice::State;
use crate::random::{Purpose, stream_of};
use crate::scene::{Scatter, Scene};
use crate::world::{Variation, draw_many};

/// The number of robots that walk side by side: one for each SIMD lane of single precision.
const ROBOTS: usize = 8;

/// The number of updates of a controller in an iteration.
const UPDATES: usize = 6;

/// What came of the updates of a controller in an iteration.
pub(super) struct Learned {
    /// The last loss.
    pub(super) loss: f64,
    /// The norm of the last gradient, before its bounds.
    pub(super) norm: f64,
    /// The number of gradients that were skipped, because they or their loss were not finite.
    pub(super) skipped: usize,
    /// True if all gradients were exactly zero.
    pub(super) is_flat: bool,
}

impl CoDesign {
    /// Like [`controller_pass`](Self::controller_pass), but the controller learns in windows. At first several do.
    pub(super) fn window_pass(
        &self,
        window: &Window,
        progress: &mut Progress,
        now: &Schedule,
        known: Option<Reached>,
        record: &mut Record,
    ) {
        let (design, rate, seed) = (self.design(progress), now.learning_rate(), progress.seed);
        let mut learners = self.learners(progress, now);
        let (learned, reached) = rayon::join(
            || {
                let each = learners.par_iter_mut();
                let each = each.map(|learner| self.learn(learner, window, &design, rate, seed));
                each.collect::<Vec<Learned>>()
            },
            || known.unwrap_or_else(|| self.evaluate(progress)),
        );
        note_displacement(record, Some(reached));
        progress.note_candidate(reached.merit);
        let first = &learned[0];
        record.loss_horizon = Some(first.loss);
        record.controller_gradient = Some(first.norm);
        record.skipped += learned.iter().map(|one| one.skipped).sum::<usize>();
        progress.note_flat(learned.iter().all(|one| one.is_flat));
        self.keep(progress, now, learners);
    }

    /// Updates a controller after each of several windows.
    fn learn(
        &self,
        learner: &mut Learner,
        window: &Window,
        design: &Design<Mixture<f64>>,
        rate: f64,
        seed: u64,
    ) -> Learned {
        let mut learned = Learned {
            loss: f64::NAN,
            norm: f64::NAN,
            skipped: 0,
            is_flat: true,
        };
        for _ in 0..UPDATES {
            let slope = self.walk_on(learner, window, design, seed);
            learned.loss = slope.loss;
            learned.is_flat &= slope.is_flat();
            let (numbers, adam) = (learner.controller.numbers_mut(), &mut learner.adam);
            let moved = self.move_numbers(numbers, adam, slope, rate);
            learned.norm = moved.norm;
            learned.skipped += usize::from(moved.is_skipped);
        }
        learned
    }

    /// Lets the robots walk through the next window. Returns the gradient of the loss with respect to the controller, a mean
    /// over the robots.
    fn walk_on(
        &self,
        learner: &mut Learner,
        window: &Window,
        design: &Design<Mixture<f64>>,
        seed: u64,
    ) -> Slope {
        let evaluator = &self.evaluator;
        let (walks, first, variations) = self.next_window(&learner.walkers, window, seed);
        let inputs = Inputs {
            z: Vec::new(),
            controller: learner.controller.clone(),
            start: evaluator.start.clone(),
        };
        let variables = Variables::Controller(design);
        let (slope, ends) = window.slope(evaluator, variables, &inputs, &variations, first);
        let rests = self.at_rest(walks, seed).into_iter().map(|v| v.start);
        // A robot that flew apart begins again.
        let next = |(end, rest): (State<f64>, _)| if end.is_absurd() { rest } else { end };
        learner.walkers = Walkers {
            walks,
            steps: first + window.span.steps(),
            states: ends.into_iter().zip(rests).map(next).collect(),
        };
        slope
    }

    /// The next window of robots that walk: the number of the walk, the steps on the clock, and the robots' variations, which
    /// begin where the last window ended. If the walk has no room for it, the next walk begins.
    pub(super) fn next_window(
        &self,
        walkers: &Walkers,
        window: &Window,
        seed: u64,
    ) -> (u64, usize, Vec<Variation>) {
        let ends = walkers.steps + window.span.steps();
        if walkers.states.is_empty() || ends > self.world().physics().steps {
            let walks = walkers.walks + 1;
            return (walks, 0, self.at_rest(walks, seed));
        }
        let mut variations = self.at_rest(walkers.walks, seed);
        for (variation, state) in variations.iter_mut().zip(&walkers.states) {
            variation.start.clone_from(state);
        }
        (walkers.walks, walkers.steps, variations)
    }

    /// The variations of the robots at the start of a walk.
    fn at_rest(&self, walks: u64, seed: u64) -> Vec<Variation> {
        let stream = stream_of(seed, Purpose::Windows, walks);
        draw_many(self.world(), &scatter(self.scene()), ROBOTS, stream)
    }
}

/// How much the robots differ: as `[robust]` says, but at least as much as the robots by which reliability is judged. Robots that
/// begin alike would stay alike.
fn scatter(scene: &Scene) -> Scatter {
    match scene.robust.samples {
        0 => VARIED,
        _ => {
            let own = scene.robust.scatter();
            Scatter {
                start: own.start.max(VARIED.start),
                friction: own.friction.max(VARIED.friction),
                stiffness: own.stiffness.max(VARIED.stiffness),
                mass: own.mass.max(VARIED.mass),
            }
        }
    }
}
