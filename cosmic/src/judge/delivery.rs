//! The delivery, which ends an optimisation: the controller of the robot is chosen, and the robot is measured.

use autodiff::Parameters;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::evaluator::Evaluator;
use super::measurements::Measuring;
use super::observed::ObservedRollout;
use super::other_steps::OtherSteps;
use super::quantiles::Quantiles;
use super::reach::{Reached, first_best, robots_of};
use super::reliability::{Merit, Reliability};
use super::sensitivity::Sensitivity;
use super::standstill::Standstill;
use super::variations::{PERTURBED_ROLLOUTS, VARIED};
use super::ways::Way;
use crate::design::{Design, Material, Mixture};
use crate::geometry::{Dimension, Vector};
use crate::policy::Controller;
use crate::random::Purpose;
use crate::scene::{GoalKind, GradientPrecision, SelectionKind};
use crate::walk::{Energy, LoadsAndEnergy};
use crate::world::{Variation, together};

/// The result of an optimisation: a robot and its measured displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct Delivery {
    /// The design of the robot. It is a layout (one material per edge) unless the optimisation ended before the snap.
    pub design: Design<[f64; 3]>,
    /// The material of every edge. If the optimisation ended before the snap, this is the material with the largest
    /// share in the edge.
    pub materials: Vec<Material>,
    /// The controller of the robot.
    pub controller: Controller<f64>,
    /// The iteration that produced the controller.
    pub iteration: usize,
    /// What the unperturbed rollout of the robot tells about it.
    pub seen: ObservedRollout,
    /// Displacement of the payload in the unperturbed rollout, along the x and y axes of the world, in metres.
    pub displacement: Vector<f64>,
    /// The quantiles by which the controller was chosen: those of its merit over perturbed starts. The merit is the
    /// displacement along the ground in metres; for tasks other than distance, it is minus the loss.
    pub selection: Quantiles,
    /// The score by which the best of several runs is chosen: the median of `selection`, or its 10 % quantile if the robot
    /// is unreliable over the starts of `selection`, or if the scene has the selection `robust`. If the robot depends on the
    /// time step or the integrator, the score is at most the lowest median merit of `other_steps`.
    pub selection_score: f64,
    /// Quantiles of the displacement along the ground of robots that vary a little, in metres: the figures to quote. How
    /// much they vary is [`VARIED`](super::VARIED) in all scenes, with or without a section `[robust]`. If goals are given,
    /// these robots have the goal of the scene.
    pub robust: Quantiles,
    /// Whether the median of `robust` describes the robot well. For tasks other than distance: whether the median loss
    /// of these robots does.
    pub reliability: Reliability,
    /// Medians with half the time step and with another integrator, over eight of the starts of `spread`.
    pub other_steps: OtherSteps,
    /// Quantiles of the displacement along the ground over perturbed starts, in metres. These starts are not the starts
    /// of `selection`. They flatter: a robot that is built is never so close to its design.
    pub spread: Quantiles,
    /// Quantiles of the displacement without feedback, over the starts of `spread`, in metres. Without feedback, the
    /// controller observes the clock and the robot's initial state, but not its current state.
    pub clock_alone: Quantiles,
    /// Quantiles of the displacement if the robot has the controller of the last iteration, over the starts of
    /// `spread`, in metres.
    pub last: Quantiles,
    /// Only for robots in space: quantiles of the displacement across, over robots that vary a little, in metres.
    pub across: Option<Quantiles>,
    /// Only for tasks other than distance: quantiles of minus the loss, over the starts of `spread`; if goals are given,
    /// over robots that vary a little and have sequences of goals.
    pub merit: Option<Quantiles>,
    /// Only beside `merit`: the same quantiles of the same robot with a controller whose numbers are all 0, so that its
    /// muscles rest.
    pub idle_merit: Option<Quantiles>,
    /// The energy of the varied robot whose displacement is nearest to the median of `robust`, per distance of that median:
    /// the figures to quote. `None` for an undecided design and if there is no median.
    pub robust_energy: Option<Energy>,
    /// The median of the displacements of `robust` with [`LOW_FRICTION`](super::LOW_FRICTION) times the friction, over eight
    /// of its robots, in metres. `None` if feet never slip, for tasks other than distance, and for an undecided design.
    pub low_friction: Option<f64>,
    /// The loads and the energy of the unperturbed walk with half the time step. `None` for an undecided design and if the
    /// walk diverges.
    pub half_step: Option<LoadsAndEnergy>,
    /// How other physics change its displacement; empty for an undecided design.
    pub sensitivities: Vec<Sensitivity>,
    /// What it leaves of its way to a goal in each direction; empty if goals are not given.
    pub ways: Vec<Way>,
}

/// A controller that may become that of the delivered robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The iteration that produced the controller.
    pub iteration: usize,
    /// The merit in one full rollout, or with the selection `robust` the 10 % quantile of several: the displacement along
    /// the ground in metres; for tasks other than distance, minus the loss.
    #[serde(rename = "along")]
    pub merit: f64,
    /// The controller.
    pub controller: Controller<f64>,
    /// Quantiles of the merit over the variations with which controllers are compared. `None` if they were not measured, or
    /// if the 10 % quantile is not finite because rollouts diverged.
    pub spread: Option<Quantiles>,
}

/// A design, and the controllers among which that of the delivered robot is chosen.
pub(crate) struct Entrants<'a> {
    pub(crate) design: &'a Design<[f64; 3]>,
    /// The controllers: that of the last iteration first, without duplicates.
    pub(crate) controllers: Vec<Candidate>,
    /// The seed of the variations.
    pub(crate) seed: u64,
}

/// How a robot walks in other circumstances than its own. The fields are those of [`Delivery`].
struct Elsewhere {
    clock_alone: Quantiles,
    other_steps: OtherSteps,
    low_friction: Option<f64>,
    half_step: Option<LoadsAndEnergy>,
    idle_merit: Option<Quantiles>,
    sensitivities: Vec<Sensitivity>,
    ways: Vec<Way>,
}

impl Evaluator {
    /// Chooses a controller, and measures the robot in full rollouts. Asks `measuring.is_stopped` after each measurement, and
    /// returns `None` as soon as that returns true.
    pub(crate) fn measure(
        &self,
        entrants: &Entrants,
        measuring: &mut Measuring,
    ) -> Option<Delivery> {
        let design = self.simulated(entrants.design);
        let (controllers, seed) = (&entrants.controllers, entrants.seed);
        let selections =
            measuring.known_or("selections", || self.selections(&design, controllers, seed))?;
        // The controller of the last iteration comes first, so it wins a tie.
        let ranked = selections.iter().zip(controllers);
        let best = first_best(ranked.map(|(spread, entrant)| self.rank(spread, entrant)));
        let (chosen, selection) = (&controllers[best], selections[best]);
        let controller = &chosen.controller;

        let starts = self.perturbed_starts(seed, Purpose::Judgement, measuring.rollouts);
        let last = (best > 0).then_some(&controllers[0].controller);
        let judged: Vec<_> = std::iter::once(controller).chain(last).collect();
        let spreads = measuring.known_or("spreads", || {
            self.spreads_over_all_and_eight(&design, &judged, &starts)
        })?;
        let seen = self.observe(&design, controller);
        measuring.go_on()?;
        let merit = self.unperturbed(&design, controller, seen.moved.forward());
        let variations = self.varied(seed, Purpose::Variation, measuring.rollouts);
        let ([robust, varied], robust_energy) = measuring.known_or("varied", || {
            self.of_varied(&design, controller, seed, &variations)
        })?;
        let elsewhere = self.elsewhere(&design, controller, [&starts, &variations], measuring)?;
        let [own, own_of_eight] = &spreads[0];
        let unsteady = self.unsteady(own_of_eight, &elsewhere.other_steps);
        Some(Delivery {
            design: entrants.design.clone(),
            materials: design.materials(),
            controller: controller.clone(),
            iteration: chosen.iteration,
            displacement: self.world.ground().vector_to_world(seen.moved),
            selection,
            selection_score: self.steady_score(
                &selection,
                merit,
                &unsteady,
                &elsewhere.other_steps,
            ),
            robust: robust.displacement,
            across: self.is_in_space().then_some(robust.across),
            reliability: self.reliability(&varied, merit, unsteady, seen.standstill),
            other_steps: elsewhere.other_steps,
            spread: own.displacement,
            clock_alone: elsewhere.clock_alone,
            last: spreads[judged.len() - 1][0].displacement,
            merit: self.quoted(own.merit, varied.merit),
            idle_merit: elsewhere.idle_merit,
            robust_energy,
            low_friction: elsewhere.low_friction,
            half_step: elsewhere.half_step,
            sensitivities: elsewhere.sensitivities,
            ways: elsewhere.ways,
            seen,
        })
    }

    /// Measures a robot from perturbed starts and with `variations`, in other circumstances than its own. `None` if the
    /// measurements are stopped.
    fn elsewhere(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        [starts, variations]: [&[Variation]; 2],
        measuring: &mut Measuring,
    ) -> Option<Elsewhere> {
        let eight = &starts[..PERTURBED_ROLLOUTS];
        let idle = controller.map(|_| 0.0);
        Some(Elsewhere {
            clock_alone: measuring.known_or("clock_alone", || {
                self.clock_alone(design, controller, starts)
            })?,
            other_steps: measuring.known_or("other_steps", || {
                self.with_other_steps(design, controller, eight)
            })?,
            low_friction: measuring.known_or("low_friction", || {
                self.on_low_friction(design, controller, variations)
            })?,
            half_step: measuring.known_or("half_step", || self.at_half_step(design, controller))?,
            idle_merit: measuring.known_or("idle_merit", || {
                self.quoted(starts, variations)
                    .map(|variations| self.spreads(design, &[&idle], variations).remove(0).merit)
            })?,
            sensitivities: match design {
                Design::Layout(_) => measuring.known_or("sensitivities", || {
                    self.sensitivities(design, controller, eight)
                })?,
                Design::Undecided(_) => Vec::new(),
            },
            ways: match self.scene.controller.goals {
                GoalKind::Given => {
                    measuring.known_or("ways", || self.ways(design, controller, eight))?
                }
                GoalKind::Fixed => Vec::new(),
            },
        })
    }

    /// The quantiles of the results of each controller over all starts, and over the first eight of them.
    fn spreads_over_all_and_eight(
        &self,
        design: &Design<Mixture<f64>>,
        controllers: &[&Controller<f64>],
        starts: &[Variation],
    ) -> Vec<[QuantilesOverVariations; 2]> {
        let reached = self.reached_over(design, controllers, starts);
        let of = |reached: &Vec<Reached>| {
            [&reached[..], &reached[..PERTURBED_ROLLOUTS]].map(QuantilesOverVariations::of)
        };
        reached.iter().map(of).collect()
    }

    /// The reasons not to trust a robot that walks differently with other time steps. `own` has its results with the
    /// scene's, from the same starts.
    fn unsteady(&self, own: &QuantilesOverVariations, other: &OtherSteps) -> Vec<String> {
        let integrator = self.scene.physics.integrator;
        self.merit().unsteady(own.merit.p50, other, integrator)
    }

    /// The [score](Self::score) of a robot, at most its median merit with other time steps if it depends on them.
    fn steady_score(
        &self,
        selection: &Quantiles,
        unperturbed: f64,
        unsteady: &[String],
        other: &OtherSteps,
    ) -> f64 {
        let score = self.score(selection, unperturbed);
        match unsteady.is_empty() {
            true => score,
            false => score.min(other.least_merit()),
        }
    }

    /// Whether a robot is reliable. `unsteady` has the reasons that follow from other time steps.
    fn reliability(
        &self,
        varied: &QuantilesOverVariations,
        unperturbed: f64,
        unsteady: Vec<String>,
        standstill: Option<Standstill>,
    ) -> Reliability {
        // A robot with another task may have reached its goal.
        let stops = standstill.filter(|_| self.loss.is_far());
        let veers = (self.is_in_space() && self.loss.is_far()).then(|| varied.veers());
        let reliability = self.merit().reliability(&varied.merit, unperturbed);
        let reliability = reliability.and(unsteady).and(veers.flatten());
        let reliability = reliability.and(stops.map(Standstill::reason));
        match self.loss.is_far() {
            true => reliability.of_walk(varied.displacement.p50, self.world.lattice().least_walk()),
            // For other tasks, a robot may have good reasons to stay.
            false => reliability,
        }
    }

    fn is_in_space(&self) -> bool {
        self.world.lattice().dimension == Dimension::Space
    }

    /// Chooses what belongs to the merit to quote, of perturbed starts and of robots that vary a little. `None` if robots are
    /// ranked by distance.
    fn quoted<T>(&self, perturbed: T, varied: T) -> Option<T> {
        match self.merit() {
            Merit::Distance { .. } => None,
            Merit::MinusLoss => Some(perturbed),
            Merit::MinusShare => Some(varied),
        }
    }

    /// The merit of a robot (the number by which robots are ranked) in the rollout from the unperturbed start. If this
    /// is the displacement along the ground in that rollout, `along` is returned, which the caller already knows.
    fn unperturbed(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        along: f64,
    ) -> f64 {
        if self.is_far() {
            return along;
        }
        self.reach(design, controller, &self.nominal()).merit
    }

    /// The score by which controllers and runs are chosen, given the quantiles of the merit over the variations of the
    /// selection, and the merit of the unperturbed rollout.
    pub(super) fn score(&self, spread: &Quantiles, unperturbed: f64) -> f64 {
        match self.scene.selection.kind {
            SelectionKind::Robust => spread.p10.min(unperturbed),
            _ => self.merit().score(spread, unperturbed),
        }
    }

    /// Two numbers by which controllers are ranked: the score of the controller's `spread`, and the median, which
    /// breaks ties.
    pub(crate) fn rank(&self, spread: &Quantiles, candidate: &Candidate) -> [f64; 2] {
        [self.score(spread, candidate.merit), spread.p50]
    }

    /// Measures robots that vary a little. Returns their displacements towards the goal of the scene, and their merits with
    /// given goals; both are the same without given goals. Also returns the energy of the robot whose displacement is
    /// nearest to the median. `variations` have given goals if the scene has them.
    fn of_varied(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        seed: u64,
        variations: &[Variation],
    ) -> ([QuantilesOverVariations; 2], Option<Energy>) {
        let reach =
            |variations: &[Variation]| self.spreads(design, &[controller], variations).remove(0);
        let varied = reach(variations);
        let energy = |robust: &QuantilesOverVariations, variations: &[Variation]| {
            let variation = &variations[robust.typical?];
            self.energy_in(design, controller, variation, robust.displacement.p50)
        };
        match self.scene.controller.goals {
            GoalKind::Fixed => ([varied; 2], energy(&varied, variations)),
            GoalKind::Given => {
                let variations = self.drawn(&VARIED, seed, Purpose::Variation, variations.len());
                let robust = reach(&variations);
                ([robust, varied], energy(&robust, &variations))
            }
        }
    }

    /// Measures a robot without feedback. Returns the quantiles of its displacement over the starts of `variations`, in
    /// metres.
    fn clock_alone(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        variations: &[Variation],
    ) -> Quantiles {
        let spreads = (self.in_open_loop()).spreads(design, &[controller], variations);
        spreads[0].displacement
    }

    /// The quantiles of the merit of each controller in `entrants` over the [selecting
    /// variations](Self::selecting_variations). Quantiles that are already known are not measured again.
    pub(crate) fn selections(
        &self,
        design: &Design<Mixture<f64>>,
        entrants: &[Candidate],
        seed: u64,
    ) -> Vec<Quantiles> {
        let variations = self.selecting_variations(seed);
        let unknown = entrants.iter().filter(|e| e.spread.is_none());
        let unknown: Vec<_> = unknown.map(|e| &e.controller).collect();
        let mut found = self.spreads(design, &unknown, &variations).into_iter();
        let spread = |e: &Candidate| e.spread.or_else(|| found.next().map(|s| s.merit));
        entrants.iter().map_while(spread).collect()
    }

    /// Measures controllers over the same variations, in parallel rollouts. Returns the quantiles of each controller's
    /// results, in the order of the controllers.
    pub(super) fn spreads(
        &self,
        design: &Design<Mixture<f64>>,
        controllers: &[&Controller<f64>],
        variations: &[Variation],
    ) -> Vec<QuantilesOverVariations> {
        let reached = self.reached_over(design, controllers, variations);
        let of = |reached: &Vec<Reached>| QuantilesOverVariations::of(reached);
        reached.iter().map(of).collect()
    }

    /// Simulates controllers with the same variations, in parallel rollouts. Returns the results of each controller.
    fn reached_over(
        &self,
        design: &Design<Mixture<f64>>,
        controllers: &[&Controller<f64>],
        variations: &[Variation],
    ) -> Vec<Vec<Reached>> {
        let count = together(controllers.len() * variations.len());
        let jobs = controllers.iter();
        let jobs: Vec<_> = jobs
            .flat_map(|c| variations.chunks(count).map(move |group| (*c, group)))
            .collect();
        let reach = |(controller, group): &(&Controller<f64>, &[Variation])| {
            self.reach_many(
                &robots_of(design, group),
                controller,
                GradientPrecision::F64,
            )
        };
        let reached: Vec<Vec<Reached>> = jobs.par_iter().map(reach).collect();
        let reached = reached.concat();
        let of_each = reached.chunks_exact(variations.len());
        of_each.map(<[Reached]>::to_vec).collect()
    }
}

/// The quantiles of one controller's results over several variations.
#[derive(Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct QuantilesOverVariations {
    pub(super) displacement: Quantiles,
    /// The displacement across; 0 for a planar robot.
    pub(super) across: Quantiles,
    pub(super) merit: Quantiles,
    /// The number of the rollout whose displacement is nearest to the median; `None` if there is no median.
    typical: Option<usize>,
}

impl QuantilesOverVariations {
    /// The quantiles over the results of one controller.
    fn of(reached: &[Reached]) -> Self {
        let displacement = spread(reached, |r| r.moved.forward());
        Self {
            displacement,
            across: spread(reached, |r| r.moved.sideways()),
            merit: spread(reached, |r| r.merit),
            typical: nearest(reached, displacement.p50),
        }
    }

    /// The reason not to trust a robot in space that goes farther across than along the ground, if it does.
    fn veers(&self) -> Option<String> {
        let (along, across) = (
            self.displacement.p50,
            self.across.p10.abs().max(self.across.p90.abs()),
        );
        let reason = || format!("it veers: {across:.2} m across, {along:.2} m along the ground");
        (across > along.abs()).then(reason)
    }
}

/// The number of the rollout whose displacement is nearest to a median; `None` if the median is not finite.
fn nearest(reached: &[Reached], median: f64) -> Option<usize> {
    let off = |k: &usize| (reached[*k].moved.forward() - median).abs();
    let there = (0..reached.len()).filter(|k| off(k).is_finite());
    there.min_by(|a, b| off(a).total_cmp(&off(b)))
}

fn spread(reached: &[Reached], of: fn(&Reached) -> f64) -> Quantiles {
    Quantiles::of(&reached.iter().map(of).collect::<Vec<_>>())
}
