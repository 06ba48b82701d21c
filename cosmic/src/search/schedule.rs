//! The schedule: settings that change over the iterations, as functions of the iteration (counted from 1).

use serde::{Deserialize, Serialize};

use crate::design::VolumeBounds;
use crate::scene::{BinarisationSettings, Scene, StartKind, VolumeSettings};

/// A phase of an optimisation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Structure, material and controller change together.
    #[default]
    CoDesign,
    /// Like `CoDesign`, but edges that clearly have a dominant material are also moved towards that material.
    Attraction,
    /// The single iteration that gives every edge one material.
    Snap,
    /// The controller changes. The design does not, except that the polish (a local search) may change the materials of
    /// single edges.
    FineTuning,
}

impl Phase {
    /// True if edges may be mixtures of materials in this phase, so that the robot cannot be built.
    pub fn is_undecided(self) -> bool {
        matches!(self, Self::CoDesign | Self::Attraction)
    }

    /// The name of the phase in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::CoDesign => "co_design",
            Self::Attraction => "attraction",
            Self::Snap => "snap",
            Self::FineTuning => "fine_tuning",
        }
    }
}

/// The kind of a pass: what one iteration of the co-design updates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PassKind {
    /// The design vectors. MMA updates them.
    Design,
    /// The controller's weights. Adam updates them.
    Controller,
}

/// Sequence of passes, which repeats (paper: three to two).
const CYCLE: [PassKind; 10] = {
    let [d, c] = [PassKind::Design, PassKind::Controller];
    [d, c, d, c, d, d, c, d, c, d]
};

/// Confidence above which an edge is attracted to its material, at the start and at the end of the attraction (found by
/// experiment).
const CONFIDENCE: [f64; 2] = [0.9, 0.6];

/// Change of the design vector of an attracted edge in an iteration, at the start and at the end of the attraction
/// (found by experiment).
const NUDGE: [f64; 2] = [0.002, 0.006];

/// First and last iteration of the widening of the volume bounds, as twenty-fourths of the iteration of the snap (paper:
/// 110 to 150 of 240).
const WIDENS: [usize; 2] = [11, 15];

/// Iterations from one polish to the next. The first polish is right after the snap. No polish happens while the
/// fine-tuning settles.
const POLISH_EVERY: usize = 3;

/// Ratio of the learning rate at the end of the fine-tuning to the rate at its start. The rate falls linearly. Once the
/// fine-tuning settles, it falls to zero (found by experiment).
const FINE_DECAY: f64 = 0.1;

/// The value of a linear ramp at an iteration. The ramp begins with `ends[0]` at iteration `over[0]` and ends with
/// `ends[1]` at iteration `over[1]`.
fn ramp(iteration: usize, ends: [f64; 2], over: [usize; 2]) -> f64 {
    let [from, to] = over.map(|i| i as f64);
    // A ramp over zero iterations is a step.
    let share = ((iteration as f64 - from) / (to - from).max(1.0)).clamp(0.0, 1.0);
    (1.0 - share) * ends[0] + share * ends[1]
}

/// The schedule of a scene at one iteration.
pub struct Schedule<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The iteration, counted from 1.
    pub iteration: usize,
}

impl<'a> Schedule<'a> {
    /// The schedule of a scene at an iteration, counted from 1.
    pub fn at(scene: &'a Scene, iteration: usize) -> Self {
        Self { scene, iteration }
    }

    /// The phase that the iteration belongs to.
    pub fn phase(&self) -> Phase {
        let schedule = &self.scene.schedule;
        if self.scene.start.kind == StartKind::Layout || self.iteration > schedule.snap_at {
            Phase::FineTuning
        } else if self.iteration == schedule.snap_at {
            Phase::Snap
        } else if self.iteration >= schedule.attraction_from {
            Phase::Attraction
        } else {
            Phase::CoDesign
        }
    }

    /// The kind of pass: whether the iteration updates the design or the controller.
    pub fn pass(&self) -> PassKind {
        CYCLE[(self.iteration - 1) % CYCLE.len()]
    }

    /// The number of simulated steps that the gradient is computed over. A horizon that is longer than the rollout ends
    /// with the rollout.
    pub fn horizon(&self) -> usize {
        let schedule = &self.scene.schedule;
        let ends = schedule.horizon.map(|steps| steps as f64);
        let horizon = ramp(self.iteration, ends, schedule.horizon_over).round() as usize;
        horizon.min(self.scene.physics.steps)
    }

    /// The volume bounds, widened for this iteration.
    pub fn volume_bounds(&self) -> VolumeBounds {
        let over = WIDENS.map(|of_24| self.scene.schedule.snap_at * of_24 / 24);
        let slack = ramp(self.iteration, [0.0, VolumeSettings::WIDENING], over);
        VolumeBounds::widened(&self.scene.volume, slack)
    }

    /// The thresholds of the binarisation measures, which fall from the measures of the first design.
    pub fn thresholds(&self, first: &[f64; 4]) -> [f64; 4] {
        let settings = &self.scene.binarisation;
        let ends = |g: f64| [g, BinarisationSettings::THRESHOLD.min(g)];
        first.map(|g| ramp(self.iteration, ends(g), settings.threshold_over))
    }

    /// Two numbers for the attraction. The first is a threshold: if the share of an edge's dominant material exceeds
    /// it, the edge is moved towards that material. The second is the size of this move.
    pub fn attraction(&self) -> (f64, f64) {
        let schedule = &self.scene.schedule;
        let over = [schedule.attraction_from, schedule.snap_at];
        let at = |ends| ramp(self.iteration, ends, over);
        (at(CONFIDENCE), at(NUDGE))
    }

    /// The number of iterations of the fine-tuning before this one.
    pub fn tuned(&self) -> usize {
        self.iteration - 1 - self.scene.schedule.snap_at
    }

    /// The number of iterations at the end of the fine-tuning in which controllers settle.
    fn settling(&self) -> usize {
        let schedule = &self.scene.schedule;
        let tuned = schedule.iterations.saturating_sub(schedule.snap_at);
        // Rounding makes products such as 0.29 times 100 slightly too small, hence the 1e-9.
        (schedule.settle * tuned as f64 + 1e-9) as usize
    }

    /// True if this iteration is among the last ones of the fine-tuning, in which controllers settle: bad updates are
    /// taken back.
    pub fn settles(&self) -> bool {
        self.iteration + self.settling() > self.scene.schedule.iterations
    }

    /// True if this iteration tries other materials for single edges before it updates the controller.
    pub fn polishes(&self) -> bool {
        let (schedule, start) = (&self.scene.schedule, self.scene.start.kind);
        let is_due = || {
            let tuned = self.iteration - schedule.snap_at - 1;
            tuned.is_multiple_of(POLISH_EVERY)
        };
        // A scene that starts from a layout keeps that layout.
        let designs = start != StartKind::Layout && self.phase() == Phase::FineTuning;
        schedule.polish_trials > 0 && designs && !self.settles() && is_due()
    }

    /// Adam's learning rate.
    pub fn learning_rate(&self) -> f64 {
        let (schedule, adam) = (&self.scene.schedule, &self.scene.adam);
        if self.phase() != Phase::FineTuning {
            return adam.rate;
        }
        let over = [schedule.snap_at + 1, schedule.iterations];
        let ends = [adam.fine_rate, adam.fine_rate * FINE_DECAY];
        // No rollout would measure the controller after the last update. So the rate falls to zero while controllers
        // settle.
        let left = if self.settles() {
            (schedule.iterations - self.iteration) as f64 / self.settling() as f64
        } else {
            1.0
        };
        left * ramp(self.iteration, ends, over)
    }
}
