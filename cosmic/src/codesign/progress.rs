//! The state of an optimisation, and the record of an iteration.

use serde::{Deserialize, Serialize};

use super::quantiles::Quantiles;
use super::schedule::Phase;
use crate::design::Design;
use crate::error::{Error, Result, fits};
use crate::objective::AugmentedLagrangian;
use crate::optimiser::{AdamState, MmaDiagnostics, MmaState};
use crate::policy::Controller;
use crate::scene::Pass;
use crate::simulator::StepCheck;

/// Iterations after which a run ends if its loss has never been a number.
const WITHOUT_LOSS: usize = 10;

/// The whole state of an optimisation: saved and read back, it continues bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Seed of all random numbers: first weights, a tilted start, perturbed starts, domains.
    pub seed: u64,
    /// The iteration after which a given robot entered: 0, or the iteration of the snap for a
    /// one-hot robot. `None` for the scene's start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entered: Option<usize>,
    /// True if the caller supplied the loss. No file can hold such a loss.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub own_loss: bool,
    /// Number of the last iteration done.
    pub iteration: usize,
    /// The design: vectors until the snap, a layout from then on.
    #[serde(flatten)]
    pub design: Design<[f64; 3]>,
    /// The controller.
    pub controller: Controller<f64>,
    /// State of the design's optimiser for each projection.
    pub mma: [MmaState; 2],
    /// State of the controller's optimiser.
    pub adam: AdamState,
    /// Multipliers and penalties.
    pub lagrangian: AugmentedLagrangian,
    /// The binarisation measures of the first design: the thresholds come down from them.
    pub first_measures: [f64; 4],
    /// The violations at the last update of the multipliers.
    pub violations: [f64; 4],
    /// Edges whose material after the snap is not the dominant one before it.
    pub flips: usize,
    /// Gradients skipped because they or their loss were not finite.
    pub skipped: usize,
    /// The fine-tuning's controllers with the longest single rollouts, best first.
    pub candidates: Vec<Candidate>,
    /// The running means of the design gradients of both projections; empty before the first
    /// design pass, and without a memory.
    #[serde(default)]
    pub design_mean: [Vec<f64>; 2],
    /// The controller to return to, from the start of settling on.
    #[serde(default)]
    pub settled: Option<Settled>,
}

impl Progress {
    /// The number of the iteration before the first one of this run.
    pub fn before_first(&self) -> usize {
        self.entered.unwrap_or(0)
    }

    /// Stops the run if the loss has never been a number: after ten or more iterations no gradient
    /// could be used, and the loss of this iteration is not finite either. Later iterations would not
    /// change that, because neither design nor controller has changed.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with the iteration and the loss.
    pub fn check_loss(&self, record: &Record) -> Result<()> {
        let done = record.iteration - self.before_first();
        let updates = self.mma.iter().map(|mma| mma.updates).sum::<u64>() + self.adam.updates;
        let lost = record.loss_horizon.filter(|loss| !loss.is_finite());
        match lost {
            Some(loss) if done >= WITHOUT_LOSS && updates == 0 && self.skipped > 0 => {
                Err(Error::NotFinite {
                    names: vec!["the loss".to_owned()],
                    cause: Some(format!(
                        "after iteration {} it is {loss}, and no gradient so far could be used; check the \
                         loss and the scene",
                        record.iteration
                    )),
                })
            }
            _ => Ok(()),
        }
    }

    /// Checks that all lists of a saved state have the lengths of another state of the same scene.
    ///
    /// # Errors
    /// [`Error::Misfit`](crate::error::Error::Misfit) with `file` and the first length that differs.
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
        for controller in std::iter::once(&self.controller)
            .chain(candidates)
            .chain(settled)
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

/// A controller of the fine-tuning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The iteration that produced it.
    pub iteration: usize,
    /// Displacement along the ground in a full rollout, m; for a task other than distance, minus
    /// the loss.
    #[serde(rename = "along")]
    pub merit: f64,
    /// The controller.
    pub controller: Controller<f64>,
    /// Quantiles of the merit over the domains that controllers are chosen by. `None` before these
    /// rollouts, and if too many of them diverged.
    #[serde(default)]
    pub spread: Option<Quantiles>,
}

/// The controller that settling returns to after a bad update.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// The last controller that lost nothing.
    pub controller: Controller<f64>,
    /// The merit that later controllers are compared with: at first the median of the best
    /// candidate, or its own rollout if that is far below, then the best single rollout. Unit as in
    /// [`Candidate::merit`].
    pub merit: f64,
    /// Factor on the learning rate, halved by every update that is taken back.
    pub trust: f64,
}

/// The record of one iteration. Lengths in metres.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Counted from 1.
    pub iteration: usize,
    /// The phase of the iteration.
    pub phase: Phase,
    /// The parts of the design that the iteration updated; `None` for the snap.
    pub pass: Option<Pass>,
    /// Displacement along the ground of a full rollout at the start of the iteration. Before the
    /// snap only some iterations have one.
    pub displacement: Option<f64>,
    /// True if that rollout diverged. The displacement is NaN then, which files cannot store.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub diverged: bool,
    /// Displacement along the ground after the horizon, in the rollout of the gradient. NaN (`None`
    /// in files) if the robot flies apart in it.
    pub displacement_horizon: Option<f64>,
    /// For a task other than distance: minus the loss over the horizon. With two goals: the merit
    /// for the goal that the robot does worse at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub merit_horizon: Option<f64>,
    /// The loss over the horizon. With two gradients, the loss of the first one or the loss that is
    /// not finite. `None` for the snap and in histories of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss_horizon: Option<f64>,
    /// Steps that carried the gradient.
    pub horizon: usize,
    /// Share of solid edges.
    #[serde(rename = "V")]
    pub volume: f64,
    /// Share of actuators.
    #[serde(rename = "V_act")]
    pub actuator_volume: f64,
    /// `g_bin` and the three overlaps.
    pub measures: [f64; 4],
    /// By how much the measures exceed their thresholds.
    pub violations: [f64; 4],
    /// Multipliers after the iteration.
    pub multipliers: [f64; 4],
    /// Penalties after the iteration.
    pub penalties: [f64; 4],
    /// Norm of the gradient of the loss by the design before any bound, for the performance and the
    /// stability projection; `None` if the projection has no share in the update.
    pub design_gradient: [Option<f64>; 2],
    /// Norm of the gradient of the loss by the controller before any bound; `None` if the learning
    /// rate is zero, and if settling took an update back.
    pub controller_gradient: Option<f64>,
    /// The solutions of the subproblems of both design updates. Their constraints are scaled: the four
    /// volume bounds come first, then the measures if they are constraints.
    pub mma: [Option<MmaDiagnostics>; 2],
    /// Gradients skipped in this iteration because they or their loss were not finite.
    pub skipped: usize,
    /// The time step compared with the vibrations of the design after the iteration; `None` in
    /// histories of older versions.
    #[serde(default)]
    pub time_step: Option<StepCheck>,
}
