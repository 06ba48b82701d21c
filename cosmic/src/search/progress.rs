//! The state of an optimisation, and the record of an iteration.

use serde::{Deserialize, Serialize};

use super::schedule::{PassKind, Phase};
use super::slope::Slope;
use super::windows::{Learner, Walkers};
use crate::design::Design;
use crate::error::{Error, Result, fits};
use crate::judge::{Candidate, Measurements};
use crate::objective::AugmentedLagrangian;
use crate::optimiser::{AdamState, MmaDiagnostics, MmaState};
use crate::policy::Controller;
use crate::world::StepCheck;

/// A run ends after this number of iterations if its loss was never finite.
const WITHOUT_LOSS: usize = 10;

/// Number of controllers whose spreads are compared: those with the best merits (found by experiment).
const CANDIDATES: usize = 6;

/// The whole state of an optimisation. An optimisation that is saved and resumed continues with the same bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// The seed of all random numbers: initial weights, the side of a tilted start, perturbed starts and variations.
    pub seed: u64,
    /// If the optimisation began with a given robot, the iteration after which that robot entered: the iteration of the
    /// snap if its design was a layout, otherwise 0. `None` if the optimisation began with the initial design of the
    /// scene.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub entered: Option<usize>,
    /// True if the caller supplied the loss, which cannot be stored in files.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub own_loss: bool,
    /// The number of the last iteration done.
    pub iteration: usize,
    /// The design. Before the snap it has a design vector for every edge; after the snap it is a layout, with one
    /// material for every edge.
    #[serde(flatten)]
    pub design: Design<[f64; 3]>,
    /// The controller.
    pub controller: Controller<f64>,
    /// The state of MMA, the optimiser of the design: one state for each projection.
    pub mma: [MmaState; 2],
    /// The state of Adam, which updates the controller.
    pub adam: AdamState,
    /// Multipliers and penalties for the binarisation measures.
    pub lagrangian: AugmentedLagrangian,
    /// The binarisation measures of the first design. The thresholds of the measures start at these values and then
    /// fall.
    pub first_measures: [f64; 4],
    /// The violations at the last update of the multipliers: by how much the measures exceeded their thresholds.
    pub violations: [f64; 4],
    /// The number of edges to which the snap gave another material than the dominant one.
    pub flips: usize,
    /// The number of gradients skipped because they or their loss were not finite.
    pub skipped: usize,
    /// The number of passes since the last one with a gradient other than zero.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub flat: usize,
    /// The best controllers of the fine-tuning, best first. They are compared by their merits.
    pub candidates: Vec<Candidate>,
    /// For each projection, the running mean of the design gradient. Both are empty before the first design pass, and
    /// always if `gradient.design_memory` is 0.
    pub design_mean: [Vec<f64>; 2],
    /// The controller to which the end of the fine-tuning (called settling) returns; `None` before that.
    pub settled: Option<Settled>,
    /// The robots that walk while the controller learns in windows.
    #[serde(default, skip_serializing_if = "is_unused")]
    pub walkers: Walkers,
    /// The controllers that compete at the start of the fine-tuning; empty at other times.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contenders: Vec<Learner>,
    /// The final measurements that are done, if the run was interrupted during its delivery.
    #[serde(default, skip_serializing_if = "Measurements::is_empty")]
    pub measurements: Measurements,
}

impl Progress {
    /// The number of the iteration before the first one of this run: 0, or the iteration after which a given robot
    /// entered.
    pub(crate) fn before_first(&self) -> usize {
        self.entered.unwrap_or(0)
    }

    /// Counts a pass that has computed these slopes.
    pub(super) fn note_slopes<'a>(&mut self, slopes: impl IntoIterator<Item = &'a Slope>) {
        let mut slopes = slopes.into_iter();
        self.note_flat(slopes.all(|slope| slope.stuck || slope.is_flat()));
    }

    /// Counts a pass, whose gradients were all zero if `is_flat` is true.
    pub(super) fn note_flat(&mut self, is_flat: bool) {
        self.flat = if is_flat { self.flat + 1 } else { 0 };
    }

    /// Inserts the current controller into the candidates, which are sorted by merit. Does nothing if the merit is not
    /// finite or the controller is already a candidate. Keeps the best `CANDIDATES`.
    pub fn note_candidate(&mut self, merit: f64) {
        let is_same = |c: &Candidate| c.controller == self.controller;
        if !merit.is_finite() || self.candidates.iter().any(is_same) {
            return;
        }
        let candidate = Candidate {
            iteration: self.iteration,
            merit,
            controller: self.controller.clone(),
            spread: None,
        };
        let place = self.candidates.partition_point(|c| c.merit >= merit);
        self.candidates.insert(place, candidate);
        self.candidates.truncate(CANDIDATES);
    }

    /// Returns an error if the loss was never finite: in ten or more iterations no gradient could be used, and the loss
    /// of the last iteration, `record`, is not finite either. Further iterations would not help, because neither the
    /// design nor the controller has changed.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the iteration and the loss.
    pub(crate) fn check_loss(&self, record: &Record) -> Result<()> {
        let done = record.iteration - self.before_first();
        let updates = self.mma.iter().map(|mma| mma.updates).sum::<u64>() + self.adam.updates;
        let lost = record.loss_horizon.filter(|loss| !loss.is_finite());
        match lost {
            Some(loss) if done >= WITHOUT_LOSS && updates == 0 && self.skipped > 0 => {
                Err(Error::NotFinite(format!(
                    "the loss; after iteration {} the loss is {loss}, and no gradient so far could be used; check \
                     the loss and the scene for divisions by zero and extreme values",
                    record.iteration
                )))
            }
            _ => Ok(()),
        }
    }

    /// Checks that all lists of this saved state have the lengths that they have in `other`, a valid state of the same
    /// scene. Errors name `file`.
    ///
    /// # Errors
    /// [`Error::Misfit`] with the first length that differs.
    pub fn fits(&self, other: &Self, file: &str) -> Result<()> {
        let fits = |what: &str, found: usize, expected: usize| {
            fits(file, &format!("entries in `{what}`"), found, expected)
        };
        let (edges, weights) = (other.design.edges(), other.controller.weights());
        fits("z", self.design.edges(), edges)?;
        fits("adam.mean", self.adam.mean.len(), weights)?;
        fits("adam.mean_square", self.adam.mean_square.len(), weights)?;
        let candidates = self.candidates.iter().map(|c| &c.controller);
        let settled = self.settled.iter().map(|s| &s.controller);
        let contenders = self.contenders.iter().map(|c| &c.controller);
        for controller in std::iter::once(&self.controller)
            .chain(candidates)
            .chain(settled)
            .chain(contenders)
        {
            let blocks = controller.blocks().zip(other.controller.blocks());
            for ((name, found, _), (expected_name, expected, _)) in blocks {
                let same = usize::from(name == expected_name);
                fits(
                    &format!("controller.{expected_name}"),
                    same * found.len(),
                    expected.len(),
                )?;
            }
            fits("controller", controller.weights(), weights)?;
        }
        for contender in &self.contenders {
            fits("contenders.adam.mean", contender.adam.mean.len(), weights)?;
            let square = &contender.adam.mean_square;
            fits("contenders.adam.mean_square", square.len(), weights)?;
        }
        for mma in &self.mma {
            fits("mma.previous", mma.previous.len(), 3 * edges)?;
            fits("mma.before_previous", mma.before_previous.len(), 3 * edges)?;
            fits("mma.low", mma.low.len(), 3 * edges)?;
            fits("mma.upp", mma.upp.len(), 3 * edges)?;
        }
        for mean in self.design_mean.iter().filter(|mean| !mean.is_empty()) {
            fits("design_mean", mean.len(), 3 * edges)?;
        }
        Ok(())
    }
}

fn is_unused(walkers: &Walkers) -> bool {
    *walkers == Walkers::default()
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// The good controller to which the end of the fine-tuning returns after a bad update.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// The last good controller.
    pub controller: Controller<f64>,
    /// The merit that a new controller must reach, in the unit of [`Candidate::merit`]. At first it is the median merit
    /// of the best candidate, or its [`Candidate::merit`] if that is much lower. Later it is the best
    /// [`Candidate::merit`].
    pub merit: f64,
    /// A factor on the learning rate. It is halved each time an update is taken back.
    pub trust: f64,
}

crate::keys! {
    /// The record of one iteration. Shares, measures and violations describe the robot before the iteration.
    #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
    struct Record {
        /// The number of the iteration, counted from 1. With `--from`, the first number is one more than `entered`.
        iteration: usize, "whole number";
        /// `co_design`, `attraction`, `snap` or `fine_tuning`.
        phase: Phase, "text";
        /// What was updated, `design` or `controller`; `null` for the snap.
        pass: Option<PassKind>, "text or `null`";
        /// Displacement along the ground of a full rollout, in every tenth iteration of the co-design and every
        /// iteration of the fine-tuning; `null` in other iterations, and if the rollout diverged.
        displacement: Option<f64>, "number or `null`", unit "m";
        /// True if the full rollout diverged; absent otherwise.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        diverged: bool, "true";
        /// True if the payload did not move at all in the last gradients, so that the gradient of the centre of mass
        /// was used; absent otherwise.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        stuck: bool, "true";
        /// Displacement along the ground in the rollout of the gradient; `null` if it diverged. The gradient is used in
        /// either case.
        displacement_horizon: Option<f64>, "number or `null`", unit "m";
        /// Only for tasks other than `far`: minus the loss over the horizon.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        merit_horizon: Option<f64>, "number", unit "the loss's";
        /// The loss over the horizon, with two gradients that of the first; `null` if a loss is not finite, and the
        /// gradient is skipped. Absent for the snap.
        #[serde(skip_serializing_if = "Option::is_none")]
        loss_horizon: Option<f64>, "number or `null`", unit "the loss's";
        /// The number of steps of the gradient's rollout.
        horizon: usize, "whole number", unit "steps";
        /// Share of solid material.
        volume as "V": f64, "number";
        /// Share of actuators.
        actuator_volume as "V_act": f64, "number";
        /// The binarisation measure, and the overlaps of void with skeleton, void with actuator, and skeleton with
        /// actuator.
        measures: [f64; 4], "four numbers";
        /// By how much the measures exceed their thresholds.
        violations: [f64; 4], "four numbers";
        /// Multipliers of the augmented Lagrangian after the iteration.
        multipliers: [f64; 4], "four numbers";
        /// Penalties of the augmented Lagrangian after the iteration.
        penalties: [f64; 4], "four numbers";
        /// Norms of the loss's gradient with respect to the design, before bounds, for the performance and the
        /// stability projection; `null` for a projection without a share in the update.
        design_gradient: [Option<f64>; 2], "two numbers or `null`s", unit "the loss's";
        /// Norm of the loss's gradient with respect to the controller, before bounds; `null` if the learning rate is
        /// zero, or if settling took an update back.
        controller_gradient: Option<f64>, "number or `null`", unit "the loss's";
        /// How the MMA subproblem of each projection was solved: `newton_steps` on the dual; `residual`, the largest
        /// violation of the optimality conditions; `elastic`, by how much each scaled constraint was violated (V at
        /// most, V at least, V_act at most, V_act at least, the measures if they are constraints).
        mma: [Option<MmaDiagnostics>; 2], "two objects or `null`s";
        /// Gradients skipped in this iteration because they or their loss were not finite.
        skipped: usize, "whole number";
        /// The time step compared with the vibrations of the design after the iteration.
        time_step: Option<StepCheck>, "object or `null`", parts StepCheck;
    }
}
