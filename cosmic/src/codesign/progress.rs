//! What an optimisation has reached, and what it tells of every iteration.

use serde::{Deserialize, Serialize};

use super::quantiles::Quantiles;
use super::schedule::Phase;
use crate::controller::Controller;
use crate::design::{Material, one_hot};
use crate::error::{Result, fits};
use crate::objective::AugmentedLagrangian;
use crate::optimiser::{AdamState, MmaState, Update};
use crate::scene::Pass;
use crate::simulator::StepCheck;

/// The whole state of an optimisation: saved and read back, it goes on bit for bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Seed of all that is drawn: first weights, a tilted start, perturbed starts, scattered
    /// domains.
    pub seed: u64,
    /// The iteration after which a robot entered that was there already: 0, or for one that was
    /// decided, the snap's. `None` for the scene's start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entered: Option<usize>,
    /// Whether robots are optimised for a loss of one's own, which no file holds.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub own_loss: bool,
    /// The iteration after which this is the state.
    pub iteration: usize,
    /// Design vectors; one-hot from the snap on.
    pub z: Vec<[f64; 3]>,
    /// The layout, from the snap on.
    pub materials: Option<Vec<Material>>,
    /// The controller.
    pub controller: Controller<f64>,
    /// Memory of the design's optimiser, for each projection.
    pub mma: [MmaState; 2],
    /// Memory of the controller's optimiser.
    pub adam: AdamState,
    /// Multipliers and penalties.
    pub lagrangian: AugmentedLagrangian,
    /// The binarisation measures of the first design: the thresholds come down from them.
    pub first_measures: [f64; 4],
    /// The violations by which the multipliers moved last.
    pub violations: [f64; 4],
    /// Edges that the snap gave another material than their largest entry's.
    pub flips: usize,
    /// Gradients that were not finite and therefore skipped.
    pub skipped: usize,
    /// The fine-tuning's controllers with the longest single rollouts, best first.
    pub candidates: Vec<Candidate>,
    /// The running means of the design gradients of both projections; empty before the first
    /// design pass, and without a memory.
    #[serde(default)]
    pub design_mean: [Vec<f64>; 2],
    /// What the end of the fine-tuning comes back to, once that has begun.
    #[serde(default)]
    pub settled: Option<Settled>,
}

impl Progress {
    /// The iteration before the first.
    pub fn before_first(&self) -> usize {
        self.entered.unwrap_or(0)
    }

    /// Gives every edge one material; the design vectors follow.
    pub(super) fn lay_out(&mut self, materials: Vec<Material>) {
        self.z = one_hot(&materials);
        self.materials = Some(materials);
    }

    /// Checks that all lists have the lengths they have in another state of the same scene, as
    /// in a saved one they may not.
    ///
    /// # Errors
    /// [`Error::Misfit`](crate::error::Error::Misfit) for the first that has not; `file` is named.
    pub fn fits(&self, other: &Self, file: &str) -> Result<()> {
        let expected = controller_sizes(&other.controller);
        let mut pairs: Vec<_> = self.sizes().into_iter().zip(other.sizes()).collect();
        let candidates = self.candidates.iter().map(|c| &c.controller);
        let settled = self.settled.iter().map(|s| &s.controller);
        for controller in candidates.chain(settled) {
            pairs.extend(controller_sizes(controller).into_iter().zip(expected));
        }
        for mean in self.design_mean.iter().filter(|mean| !mean.is_empty()) {
            let variables = 3 * other.z.len();
            pairs.push((("design_mean", mean.len()), ("design_mean", variables)));
        }
        if let Some(materials) = &self.materials {
            pairs.push((("materials", materials.len()), ("materials", other.z.len())));
        }
        pairs
            .into_iter()
            .try_for_each(|((what, found), (_, expected))| {
                fits(file, &format!("entries in `{what}`"), found, expected)
            })
    }

    /// The lists whose lengths a scene sets.
    fn sizes(&self) -> Vec<(&'static str, usize)> {
        let mut sizes = vec![
            ("z", self.z.len()),
            ("adam.mean", self.adam.mean.len()),
            ("adam.mean_square", self.adam.mean_square.len()),
        ];
        sizes.extend(controller_sizes(&self.controller));
        for mma in &self.mma {
            sizes.extend([
                ("mma.previous", mma.previous.len()),
                ("mma.before_previous", mma.before_previous.len()),
                ("mma.low", mma.low.len()),
                ("mma.upp", mma.upp.len()),
            ]);
        }
        sizes
    }
}

fn controller_sizes(controller: &Controller<f64>) -> [(&'static str, usize); 6] {
    [
        ("controller.inputs", controller.inputs),
        ("controller.hidden", controller.hidden),
        ("controller.w1", controller.w1.len()),
        ("controller.b1", controller.b1.len()),
        ("controller.w2", controller.w2.len()),
        ("controller.b2", controller.b2.len()),
    ]
}

/// A controller of the fine-tuning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The iteration after which it stood.
    pub iteration: usize,
    /// How far a full rollout got with it, m along the ground; for another task than to get far,
    /// minus its loss.
    #[serde(rename = "along")]
    pub merit: f64,
    /// The controller.
    pub controller: Controller<f64>,
    /// The same over the perturbed starts by which controllers are chosen, where these rollouts
    /// were done and none diverged.
    #[serde(default)]
    pub spread: Option<Quantiles>,
}

/// What the rest of the fine-tuning comes back to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settled {
    /// The last controller that lost nothing.
    pub controller: Controller<f64>,
    /// What it is held against: at first the median of the best candidate, or its own rollout if
    /// that is far behind, later the best single rollout; m along the ground, for another task than
    /// to get far minus its loss.
    pub merit: f64,
    /// What is left of the learning rate: halved by every update that is taken back.
    pub trust: f64,
}

/// One iteration, for the history. Lengths in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Counted from 1.
    pub iteration: usize,
    /// What the iteration belongs to.
    pub phase: Phase,
    /// What it updated; the snap updates neither.
    pub pass: Option<Pass>,
    /// Displacement along the ground of a full rollout at the iteration's start; not every
    /// iteration of the co-design has one.
    pub displacement: Option<f64>,
    /// Displacement along the ground after the horizon, in the rollout of the gradient.
    pub displacement_horizon: Option<f64>,
    /// For another task than to get far: minus the loss over the horizon that the gradient is of.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub merit_horizon: Option<f64>,
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
    /// By how much they exceed their thresholds.
    pub violations: [f64; 4],
    /// Multipliers after the iteration.
    pub multipliers: [f64; 4],
    /// Penalties after the iteration.
    pub penalties: [f64; 4],
    /// Norm of the displacement's gradient by the design, before any bound: performance and
    /// stability projection; `None` where updates by it have no share.
    pub design_gradient: [Option<f64>; 2],
    /// Norm of the gradient by the controller, before any bound; `None` where the rate is zero,
    /// and where settling takes the update back.
    pub controller_gradient: Option<f64>,
    /// How the subproblems of both design updates were solved.
    pub mma: [Option<MmaDiagnostics>; 2],
    /// Gradients skipped in this iteration because they were not finite.
    pub skipped: usize,
    /// The time step against the vibrations of the design after the iteration; rows of older
    /// histories have none.
    #[serde(default)]
    pub time_step: Option<StepCheck>,
}

/// How a subproblem of the design's optimiser was solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MmaDiagnostics {
    /// Newton steps of the dual.
    pub newton_steps: usize,
    /// Largest violation of the optimality conditions.
    pub residual: f64,
    /// Elastic variables of the constraints, as they are scaled for MMA: what could not be met. The
    /// four volume bounds come first, then the measures where those are constraints.
    pub elastic: Vec<f64>,
}

impl From<Update> for MmaDiagnostics {
    fn from(update: Update) -> Self {
        Self {
            newton_steps: update.newton_steps,
            residual: update.residual,
            elastic: update.elastic,
        }
    }
}
