//! The variations of robots by which robots are ranked, chosen and judged.

use std::sync::Arc;

use super::evaluator::Evaluator;
use crate::policy::Goals;
use crate::random::{Purpose, stream, stream_of};
use crate::scene::{GoalKind, Scatter, SelectionKind, SelectionSettings};
use crate::world::{Variation, draw_goals, draw_many, perturbed};

/// The number of variations with which robots are ranked and controllers are chosen.
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
    pub(crate) fn nominal(&self) -> Variation {
        self.world.nominal(&self.start)
    }

    /// The variations with which robots are ranked during an optimisation: the robot as designed, and robots that
    /// [vary](VARIED) a little.
    pub(super) fn ranking_variations(&self, seed: u64) -> Vec<Variation> {
        let mut variations = self.drawn(&VARIED, seed, Purpose::Ranking, PERTURBED_ROLLOUTS);
        variations[0] = self.nominal();
        self.on_errands(variations, seed, Purpose::Ranking)
    }

    /// The variations with which controllers are measured to choose one: for the selection `robust` robots that
    /// [vary](VARIED) a little, otherwise those of the section `[robust]` (domain randomisation), or perturbed starts
    /// without that section.
    pub(super) fn selecting_variations(&self, seed: u64) -> Vec<Variation> {
        let robust = &self.scene.robust;
        let (purpose, variations) = match (self.scene.selection.kind, robust.samples) {
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
        self.on_errands(variations, seed, purpose)
    }

    /// This number of variations with [varied](VARIED) robots. If goals are given, each robot has a sequence of goals.
    pub(super) fn varied(&self, seed: u64, purpose: Purpose, count: usize) -> Vec<Variation> {
        self.on_errands(self.drawn(&VARIED, seed, purpose, count), seed, purpose)
    }

    /// These variations, each with a sequence of goals; unchanged if goals are fixed.
    fn on_errands(
        &self,
        variations: Vec<Variation>,
        seed: u64,
        purpose: Purpose,
    ) -> Vec<Variation> {
        match self.scene.controller.goals {
            GoalKind::Fixed => variations,
            GoalKind::Given => {
                let goals = &self.scene.goals;
                let mut stream = stream_of(seed, Purpose::Errands, purpose as u64);
                with_goals(variations, |k, _| {
                    let ahead = k.is_multiple_of(2);
                    draw_goals(&self.world, goals, ahead, &mut stream)
                })
            }
        }
    }

    /// This number of variations that differ at random. The first ones do not depend on the number.
    pub(super) fn drawn(
        &self,
        scatter: &Scatter,
        seed: u64,
        purpose: Purpose,
        count: usize,
    ) -> Vec<Variation> {
        draw_many(&self.world, scatter, count, stream(seed, purpose))
    }

    /// Variations that are the robot as designed from perturbed starts. To perturb a start,
    /// [`PERTURBATION`](SelectionSettings::PERTURBATION), in units of the lattice's scale, is added to or subtracted from
    /// every coordinate, at random.
    pub(super) fn perturbed_starts(
        &self,
        seed: u64,
        purpose: Purpose,
        count: usize,
    ) -> Vec<Variation> {
        let mut stream = stream(seed, purpose);
        let distance = SelectionSettings::PERTURBATION * self.world.lattice().scale;
        let mut start = || perturbed(&self.start, distance, &mut stream);
        let nominal = self.nominal();
        let variation = |_| Variation {
            start: start(),
            ..nominal.clone()
        };
        (0..count).map(variation).collect()
    }
}

/// These variations, each with its own goals: `draw` gets its number and the variation.
pub(crate) fn with_goals(
    mut variations: Vec<Variation>,
    mut draw: impl FnMut(usize, &Variation) -> Goals,
) -> Vec<Variation> {
    for (k, variation) in variations.iter_mut().enumerate() {
        let goals = draw(k, variation);
        variation.surroundings = Arc::new((*variation.surroundings).clone().with_goals(goals));
    }
    variations
}
