//! The contest of gaits, with which learning in windows begins.
//!
//! Gradients do not leave the gait in which they begin. So beside the controller that was there at the snap, others begin anew,
//! each with a clock of its own frequency. All learn for some iterations. Then they are compared, and the best one goes on.

use rayon::prelude::*;

use super::begin::CoDesign;
use super::progress::Progress;
use super::schedule::Schedule;
use super::windows::{Learner, Walkers};
use crate::judge::first_best;
use crate::policy::{Controller, TEMPO};
use crate::scene::ClockKind;

/// The frequencies of the clocks, as factors on that of the scene. The first one is that of the controller that was there at the
/// snap, whatever its clock has become.
const FREQUENCIES: [f64; 8] = [1.0, 1.0, 1.4, 2.0, 2.8, 4.0, 0.7, 0.5];

/// The number of iterations of the contest.
const ROUNDS: usize = 4;

/// The contest begins only if it takes at most one in this many iterations of the fine-tuning.
const SHORT: usize = 3;

impl CoDesign {
    /// The number of iterations of the contest: none if controllers learn over the horizon, and in a short fine-tuning.
    pub fn contest(&self) -> usize {
        let schedule = &self.scene().schedule;
        let tunings = schedule.iterations.saturating_sub(schedule.snap_at);
        match self.window {
            Some(_) if tunings >= SHORT * ROUNDS => ROUNDS,
            _ => 0,
        }
    }

    /// The controllers that learn in an iteration. In the first iteration of the fine-tuning the contest begins; after its last
    /// one the best controller remains.
    pub(super) fn learners(&self, progress: &mut Progress, now: &Schedule) -> Vec<Learner> {
        let own = Learner {
            controller: progress.controller.clone(),
            adam: progress.adam.clone(),
            walkers: progress.walkers.clone(),
        };
        match now.tuned() {
            0 if self.contest() > 0 => {
                let others = (1..FREQUENCIES.len()).map(|k| self.contender(progress.seed, k));
                std::iter::once(own).chain(others).collect()
            }
            _ if progress.contenders.is_empty() => vec![own],
            _ => std::mem::take(&mut progress.contenders),
        }
    }

    /// A controller that begins anew.
    fn contender(&self, seed: u64, k: usize) -> Learner {
        let (settings, lattice) = (&self.scene().controller, self.world().lattice());
        // Each draws its weights with a seed of its own.
        let seed = seed.wrapping_add((k as u64) << 32);
        let mut controller = Controller::xavier(settings, lattice, seed);
        if settings.clock == ClockKind::Learned {
            controller.block_mut(TEMPO)[0] = FREQUENCIES[k].ln();
        }
        Learner {
            adam: self.adam.init(controller.weights()),
            controller,
            walkers: Walkers::default(),
        }
    }

    /// Keeps the controllers that have learned: all of them until the contest ends, and then the one with the best merit.
    pub(super) fn keep(&self, progress: &mut Progress, now: &Schedule, mut learners: Vec<Learner>) {
        if learners.len() > 1 && now.tuned() + 1 >= ROUNDS {
            let best = self.best(progress, &learners);
            learners.swap(0, best);
            learners.truncate(1);
        }
        let Learner {
            controller,
            adam,
            walkers,
        } = learners[0].clone();
        (progress.controller, progress.adam, progress.walkers) = (controller, adam, walkers);
        if learners.len() > 1 {
            progress.contenders = learners;
        }
    }

    /// The number of the learner with the best merit.
    fn best(&self, progress: &Progress, learners: &[Learner]) -> usize {
        let designs = [self.design(progress)];
        let merit = |learner: &Learner| {
            let reached = (self.evaluator).ranked(&designs, &learner.controller, progress.seed);
            [reached[0].merit]
        };
        first_best(learners.par_iter().map(merit).collect::<Vec<_>>())
    }
}
