//! The domains in which robots are simulated: those of gradients, and those in which robots are ranked, chosen and judged.

use std::sync::Arc;

use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use super::evaluator::Evaluator;
use super::progress::Progress;
use super::reach::robots_of;
use super::schedule::Schedule;
use crate::policy::Goals;
use crate::random::{Purpose, stream, stream_of};
use crate::scene::{GoalKind, GoalsSettings, Scatter, SelectionKind, SelectionSettings};
use crate::world::{Variation, draw_goal, draw_goals, draw_many, perturbed, together};

/// The number of domains in which robots are ranked and controllers are chosen.
pub(super) const PERTURBED_ROLLOUTS: usize = SelectionSettings::PERTURBED_ROLLOUTS;

/// The variations by which the reliability of a robot is judged, and by which the selection `robust` chooses
/// controllers: 1 % of a spacing in the start, 5 % of the friction, and 5 % of the stiffness of every edge. They are the
/// same in all scenes, so that robots of different scenes can be compared.
pub const VARIED: Scatter = Scatter {
    start: 0.001,
    friction: 0.05,
    stiffness: 0.05,
    mass: 0.0,
};

impl Evaluator {
    /// The robot as designed, from the unperturbed start.
    pub(super) fn nominal(&self) -> Variation {
        self.world.nominal(&self.start)
    }

    /// The domains over which an iteration averages its gradients, and the number of steps on the clock at their starts.
    /// Empty for a scene without domain randomisation and without given goals. They depend only on the robot, the seed and
    /// the iteration, so that a resumed run draws the same domains.
    pub fn domains(&self, progress: &Progress, now: &Schedule) -> (usize, Vec<Variation>) {
        let (robust, goals) = (&self.scene.robust, self.scene.controller.goals);
        let number = now.iteration as u64;
        let stream = |purpose| stream_of(progress.seed, purpose, number);
        let count = match goals {
            GoalKind::Fixed => robust.samples,
            GoalKind::Given => GoalsSettings::SAMPLES,
        };
        let domains = match robust.samples {
            0 => vec![self.nominal(); count],
            _ => {
                let stream = stream(Purpose::DomainRandomisation);
                draw_many(&self.world, &robust.scatter(), count, stream)
            }
        };
        match goals {
            GoalKind::Fixed => (0, domains),
            GoalKind::Given => {
                let rest = self.scene.physics.steps.saturating_sub(now.horizon());
                self.with_a_goal(domains, progress, rest, stream(Purpose::Goals))
            }
        }
    }

    /// These domains, each with one goal: half of the goals are ahead, half behind. In one of
    /// [`COUNT`](GoalsSettings::COUNT) iterations, robots begin at rest, as in a sequence of goals. In the others they
    /// are on their way to a goal before, for the number of steps that is returned, at most `rest`.
    fn with_a_goal(
        &self,
        domains: Vec<Variation>,
        progress: &Progress,
        rest: usize,
        mut stream: ChaCha8Rng,
    ) -> (usize, Vec<Variation>) {
        let goals = &self.scene.goals;
        let whole = (self.scene.physics.steps / GoalsSettings::COUNT).min(rest);
        let steps = match progress.iteration % GoalsSettings::COUNT {
            0 => 0,
            _ => stream.random_range(whole / 2..=whole),
        };
        let mut with_one = |domains: Vec<Variation>, in_turn: usize| {
            with_goals(domains, |k, domain| {
                let ahead = (k / in_turn).is_multiple_of(2);
                draw_goal(&self.world, &domain.start, goals, ahead, &mut stream)
            })
        };
        let mut domains = with_one(domains, 1);
        if steps == 0 {
            return (0, domains);
        }
        let (design, controller) = (self.design(progress), &progress.controller);
        let precision = self.scene.gradient.precision;
        let walk = |domains: &[Variation]| {
            let robots = robots_of(&design, domains);
            self.watched(&robots, controller, vec![steps], precision)
        };
        let chunks = domains.par_chunks(together(domains.len()));
        let walked: Vec<_> = chunks.flat_map_iter(walk).collect();
        for (domain, walked) in domains.iter_mut().zip(walked) {
            if let Some(mut walked) = walked {
                domain.start = walked.states.remove(0);
            }
        }
        // The goals ahead and behind follow goals ahead and behind equally often.
        (steps, with_one(domains, 2))
    }

    /// The domains in which robots are ranked during an optimisation: the robot as designed, and robots that
    /// [vary](VARIED) a little.
    pub(super) fn ranking_domains(&self, seed: u64) -> Vec<Variation> {
        let mut domains = self.drawn(&VARIED, seed, Purpose::Ranking, PERTURBED_ROLLOUTS);
        domains[0] = self.nominal();
        self.on_errands(domains, seed, Purpose::Ranking)
    }

    /// The domains in which controllers are measured to choose one: for the selection `robust` robots that vary a
    /// little, otherwise random domains if the scene has domain randomisation, or perturbed starts.
    pub(super) fn selecting_domains(&self, seed: u64) -> Vec<Variation> {
        let robust = &self.scene.robust;
        let (purpose, domains) = match (self.scene.selection.kind, robust.samples) {
            (SelectionKind::Robust, _) => {
                return self.varied(seed, Purpose::Selection, PERTURBED_ROLLOUTS);
            }
            (_, 0) => {
                let purpose = Purpose::Selection;
                let starts = self.perturbed_starts(seed, purpose, PERTURBED_ROLLOUTS);
                (purpose, starts)
            }
            _ => {
                let purpose = Purpose::DomainRandomisation;
                let drawn = self.drawn(&robust.scatter(), seed, purpose, PERTURBED_ROLLOUTS);
                (purpose, drawn)
            }
        };
        self.on_errands(domains, seed, purpose)
    }

    /// This number of domains with [varied](VARIED) robots. If goals are given, each robot has a sequence of goals.
    pub(super) fn varied(&self, seed: u64, purpose: Purpose, count: usize) -> Vec<Variation> {
        self.on_errands(self.drawn(&VARIED, seed, purpose, count), seed, purpose)
    }

    /// These domains, each with a sequence of goals; unchanged if goals are fixed.
    fn on_errands(&self, domains: Vec<Variation>, seed: u64, purpose: Purpose) -> Vec<Variation> {
        match self.scene.controller.goals {
            GoalKind::Fixed => domains,
            GoalKind::Given => {
                let goals = &self.scene.goals;
                let mut stream = stream_of(seed, Purpose::Errands, purpose as u64);
                with_goals(domains, |k, _| {
                    let ahead = k.is_multiple_of(2);
                    draw_goals(&self.world, goals, ahead, &mut stream)
                })
            }
        }
    }

    /// This number of domains that differ at random. The first ones do not depend on the number.
    pub(super) fn drawn(
        &self,
        scatter: &Scatter,
        seed: u64,
        purpose: Purpose,
        count: usize,
    ) -> Vec<Variation> {
        draw_many(&self.world, scatter, count, stream(seed, purpose))
    }

    /// Copies of the nominal task, each with a perturbed start. To perturb a start,
    /// [`PERTURBATION`](SelectionSettings::PERTURBATION), in units of the lattice's scale, is added to or subtracted from
    /// every coordinate, at random.
    pub(super) fn perturbed_starts(
        &self,
        seed: u64,
        purpose: Purpose,
        count: usize,
    ) -> Vec<Variation> {
        let mut stream = stream(seed, purpose);
        let distance = SelectionSettings::PERTURBATION * self.world.lattice.scale;
        let mut start = || perturbed(&self.start, distance, &mut stream);
        let nominal = self.nominal();
        let domain = |_| Variation {
            start: start(),
            ..nominal.clone()
        };
        (0..count).map(domain).collect()
    }
}

/// These domains, each with its own goals: `draw` gets its number and the domain.
fn with_goals(
    mut domains: Vec<Variation>,
    mut draw: impl FnMut(usize, &Variation) -> Goals,
) -> Vec<Variation> {
    for (k, domain) in domains.iter_mut().enumerate() {
        let goals = draw(k, domain);
        domain.surroundings = Arc::new(domain.surroundings.with_goals(&goals));
    }
    domains
}
