//! The summary: every number of a delivered robot, and what its verdict judges.

use crate::design::{Structure, VolumeBounds};
use crate::geometry::Dimension;
use crate::judge::verdict::{HalfStep, Measured};
use crate::judge::{Delivery, Quantiles, Reliability, Sensitivity, Standstill, Way};
use crate::lattice::Lattice;
use crate::numbers::{finite, fixed};
use crate::scene::{Scene, VolumeSettings};
use crate::search::Progress;
use crate::walk::{Energy, Loads};
use serde::{Deserialize, Deserializer, Serialize};

crate::keys! {
    /// The result of a run. Displacements are those of the payload over a whole rollout. A displacement is
    /// `None` if too many rollouts diverged to determine it.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Summary {
        /// Name of the scene.
        scene: String, "text";
        /// The seed; of several starts, the seed of the best one.
        seed: u64, "whole number";
        /// Median displacement along the ground from 24 perturbed starts, which differ by about a nanometre.
        displacement_p50: Option<f64>, "number or `null`", unit "m", columns ["displacement_p50"];
        /// 10 % quantile of the displacements of `displacement_p50`.
        displacement_p10: Option<f64>, "number or `null`", unit "m", columns ["displacement_p10"];
        /// 90 % quantile of the displacements of `displacement_p50`.
        displacement_p90: Option<f64>, "number or `null`", unit "m", columns ["displacement_p90"];
        /// Median displacement along the ground of 24 robots that vary a little: the figure to quote.
        displacement_robust_p50: Option<f64>, "number or `null`", unit "m", columns ["displacement_robust_p50"];
        /// 10 % quantile of the displacements of `displacement_robust_p50`.
        displacement_robust_p10: Option<f64>, "number or `null`", unit "m", columns ["displacement_robust_p10"];
        /// Only for robots in space: median displacement across of robots that vary a little.
        #[serde(skip_serializing_if = "Option::is_none")]
        across_robust_p50: Option<f64>, "number", unit "m", columns ["across_robust_p50"];
        /// 10 % quantile of the displacements across of `across_robust_p50`.
        #[serde(skip_serializing_if = "Option::is_none")]
        across_robust_p10: Option<f64>, "number", unit "m", columns ["across_robust_p10"];
        /// 90 % quantile of the displacements across of `across_robust_p50`.
        #[serde(skip_serializing_if = "Option::is_none")]
        across_robust_p90: Option<f64>, "number", unit "m", columns ["across_robust_p90"];
        /// Median with half the time step, over eight of the starts of `displacement_p50`.
        displacement_half_step_p50: Option<f64>, "number or `null`", unit "m", columns ["displacement_half_step_p50"];
        /// Median with another integrator, over eight of the starts of `displacement_p50`. It is leapfrog for symplectic
        /// Euler, otherwise symplectic Euler. `null` also if that needs more than 64 substeps.
        displacement_integrator_p50: Option<f64>, "number or `null`", unit "m", columns ["displacement_integrator_p50"];
        /// Median with 0.6 times the friction, over eight of the robots of `displacement_robust_p50`. `null` also if feet
        /// never slip, for tasks other than `far` and for an undecided design.
        displacement_low_friction_p50: Option<f64>, "number or `null`", unit "m", columns ["displacement_low_friction_p50"];
        /// Like `displacement_p50`, with the controller of the last iteration.
        displacement_last_p50: Option<f64>, "number or `null`", unit "m", columns ["displacement_last_p50"];
        /// Like `displacement_p50`, without feedback: the controller observes the clock, and the robot as it is at the
        /// start.
        displacement_clock_p50: Option<f64>, "number or `null`", unit "m", columns ["displacement_clock_p50"];
        /// Displacement along the ground in one unperturbed rollout of the delivered robot.
        displacement_along: f64, "number", unit "m", columns ["displacement_along"];
        /// Like `displacement_along`, along the x and y axes of the world.
        displacement: [f64; 2], "two numbers", unit "m", columns ["displacement_x", "displacement_y"];
        /// Median displacement in the rollouts by which the controller was chosen; for tasks other than `far`, minus
        /// the median loss.
        displacement_selection_p50: Option<f64>, "number or `null`", unit "m";
        /// The score by which the best of several runs is chosen.
        displacement_selection_score: Option<f64>, "number or `null`", unit "m";
        /// Whether the median over varied robots describes the robot well: `verdict` is `reliable`, or `unreliable`
        /// with a `reason`, and with `stays_in_place` if it should walk far but stays in place.
        reliability: Reliability, "object";
        /// Only if the robot stopped before the last quarter of the unperturbed rollout: when and where.
        #[serde(skip_serializing_if = "Option::is_none")]
        standstill: Option<Standstill>, "object", parts Standstill;
        /// Only for tasks other than `far`: the median loss over the starts of `displacement_p50`; with given goals,
        /// over varied robots with sequences of goals. `null` if too many rollouts diverged.
        #[serde(skip_serializing_if = "Option::is_none", default, deserialize_with = "present")]
        loss_p50: Option<Option<f64>>, "number or `null`", unit "the loss's", columns ["loss_p50"] decimals 4;
        /// Only beside `loss_p50`: the same median while the muscles rest.
        #[serde(skip_serializing_if = "Option::is_none")]
        loss_idle_p50: Option<f64>, "number", unit "the loss's";
        /// Mean share of solid material (skeleton and actuator) over the edges.
        volume as "V": f64, "number", columns ["V"] decimals 4;
        /// Mean share of actuators.
        actuator_volume as "V_act": f64, "number", columns ["V_act"] decimals 4;
        /// True if the run ended before every edge had one material. Then `structure` and `loads` are `null`.
        undecided: bool, "true or false";
        /// How the bars (edges of solid material) are connected.
        structure: Option<Structure>, "object or `null`", parts Structure as columns;
        /// The loads of actuators and bars over all steps of the unperturbed rollout.
        loads: Option<Loads>, "object or `null`", parts Loads as columns;
        /// The mass, and the energy of the unperturbed rollout. Absent for an undecided design.
        #[serde(skip_serializing_if = "Option::is_none")]
        energy: Option<Energy>, "object", parts Energy;
        /// The energy of the varied robot whose displacement is nearest to `displacement_robust_p50`, per distance of
        /// this median: the figures to quote. Absent if there is no median.
        #[serde(skip_serializing_if = "Option::is_none")]
        energy_robust: Option<Energy>, "object", parts Energy as columns;
        /// Like `loads`, with half the time step. Absent for an undecided design and for a walk that diverges.
        #[serde(skip_serializing_if = "Option::is_none")]
        loads_half_step: Option<Loads>, "object";
        /// Like `energy`, with half the time step. Absent if `loads_half_step` is absent.
        #[serde(skip_serializing_if = "Option::is_none")]
        energy_half_step: Option<Energy>, "object";
        /// How other physics change the displacement. Absent for an undecided design.
        #[serde(skip_serializing_if = "Vec::is_empty", default)]
        sensitivities: Vec<Sensitivity>, "list of objects", parts Sensitivity;
        /// Only with given goals: what the robot leaves of its way to a goal ahead and behind, in space in eight directions.
        #[serde(skip_serializing_if = "Vec::is_empty", default)]
        ways: Vec<Way>, "list of objects", parts Way;
        /// Edges to which the snap gave another material than the dominant one.
        flips: usize, "whole number",
            columns ["flips"] of |s: &Summary| (!s.undecided).then_some(s.flips);
        /// Gradients that were skipped because they or their loss were not finite.
        skipped_gradients: usize, "whole number", columns ["skipped_gradients"];
        /// Only with `--from`: the iteration after which the robot entered, 0 or the iteration of the snap.
        #[serde(skip_serializing_if = "Option::is_none")]
        entered: Option<usize>, "whole number";
        /// Iterations done by this run.
        iterations: usize, "whole number";
        /// The iteration that produced the delivered controller.
        delivered_iteration: usize, "whole number", columns ["delivered_iteration"];
        /// `finished`, or `unfinished` if iterations of the scene are left.
        stop_reason: StopReason, "text";
        /// Version of the program.
        cosmic_version: String, "text";
        /// Wall time without interruptions; with several starts, the sum over all starts.
        seconds: f64, "number", unit "s", columns ["seconds"] decimals 1;
        /// Only with several starts: the starts, in the order of their seeds. The summary is that of the best one.
        #[serde(skip_serializing_if = "Vec::is_empty", default)]
        starts: Vec<Start>, "list of objects", parts Start;
    }
}

/// Reads a key that is absent or has a value: `null` is a value, too.
fn present<'de, D: Deserializer<'de>>(value: D) -> Result<Option<Option<f64>>, D::Error> {
    Option::deserialize(value).map(Some)
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// All iterations of the scene are done.
    Finished,
    /// Iterations of the scene are left: the run was interrupted, or its plan has fewer.
    Unfinished,
}

crate::keys! {
    /// One of several starts.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
    struct Start {
        /// The seed, and the name of the folder.
        seed: u64, "whole number";
        /// As in the summary of the start; `null` if it diverged.
        displacement_selection_p50: Option<f64>, "number or `null`", unit "m";
        /// As in the summary of the start. The best start has the highest score.
        displacement_selection_score: Option<f64>, "number or `null`", unit "m";
        /// As in the summary of the start.
        displacement_robust_p50: Option<f64>, "number or `null`", unit "m";
        /// As in the summary of the start.
        #[serde(skip_serializing_if = "Option::is_none")]
        reliability: Option<Reliability>, "object";
    }
}

impl Start {
    /// Makes the entry of a start in the list of starts. `summary` is `None` if the start diverged.
    pub fn new(seed: u64, summary: Option<&Summary>) -> Self {
        Self {
            seed,
            displacement_selection_p50: summary.and_then(|s| s.displacement_selection_p50),
            displacement_selection_score: summary.and_then(|s| s.displacement_selection_score),
            displacement_robust_p50: summary.and_then(|s| s.displacement_robust_p50),
            reliability: summary.map(|s| s.reliability.clone()),
        }
    }
}

/// The ratio `a / b` of two displacements (m). `None` if it would be misleading: if `b` is below 1 cm or `a` is negative
/// (the robot walks backwards).
pub fn ratio(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let (a, b) = (a.filter(|a| *a >= 0.0), b.filter(|b| *b >= 0.01));
    Option::zip(a, b).map(|(a, b)| a / b)
}

impl Summary {
    /// The robot's displacement without feedback divided by its displacement with feedback, as a [`ratio`]. `None` also
    /// for an unreliable robot.
    pub fn clock_keeps(&self) -> Option<f64> {
        let whole = self.displacement_p50.filter(|_| !self.is_unreliable());
        ratio(self.displacement_clock_p50, whole)
    }

    /// The share that the robot leaves of its ways to goals, as a mean over the directions; `None` if goals are not given,
    /// or if a direction has no median.
    pub fn way_left(&self) -> Option<f64> {
        let left: Option<Vec<f64>> = self.ways.iter().map(|way| way.left).collect();
        let left = left.filter(|left| !left.is_empty())?;
        Some(left.iter().sum::<f64>() / left.len() as f64)
    }

    /// What the robot leaves of its ways to goals, in words; `None` if goals are not given.
    pub fn ways_in_words(&self) -> Option<String> {
        let first = self.ways.first()?;
        let share = |way: &Way| match way.left {
            Some(left) => format!("{} {} %", way.name(), fixed(100.0 * left, 0)),
            None => format!("{} diverged", way.name()),
        };
        let shares: Vec<String> = self.ways.iter().map(share).collect();
        let way = fixed(first.way, 2);
        Some(format!(
            "left of the way to a goal {way} m away: {}",
            shares.join(", ")
        ))
    }

    /// Why the robot is unreliable; `None` for a reliable robot.
    pub fn unreliable(&self) -> Option<&str> {
        self.reliability.reason()
    }

    /// What a verdict judges: numbers of the summary and of `scene`, the scene of the run.
    pub fn measured(&self, scene: &Scene, lattice: &Lattice) -> Measured<'_> {
        // Without `..`, so that the compiler reports a field that is missing here.
        Measured {
            seconds: scene.physics.steps as f64 * scene.physics.dt,
            displacement: self.displacement_robust_p50,
            across: self.across_robust_p10.zip(self.across_robust_p90),
            low_friction: self.displacement_low_friction_p50,
            length: lattice.body_length(),
            is_planar: lattice.dimension == Dimension::Plane,
            slips: scene.slips(),
            standstill: self.standstill,
            reliability: &self.reliability,
            is_far: self.is_far(),
            losses: self.loss_p50.flatten().zip(self.loss_idle_p50),
            way_left: self.way_left(),
            is_undecided: self.undecided,
            structure: self.structure,
            loads: self.loads.as_ref(),
            energy: self.quoted_energy(),
            half_step: self.half_step(),
            bars: (self.volume * lattice.edges.len() as f64).round() as usize,
            volumes: [self.volume, self.actuator_volume],
            bounds: VolumeBounds::widened(&scene.volume, VolumeSettings::WIDENING),
            risers: scene.risers_ahead(lattice),
            payload: scene.payload_mass(lattice),
            load: scene.share_of_lift(lattice),
            friction_margin: scene.friction_margin(),
            actuator_strain: scene.materials.actuator_strain(),
            sheet: scene.data_sheet(),
        }
    }

    /// The mass and the energy to quote: those of the walk of `displacement_robust_p50`, or of the unperturbed walk.
    pub fn quoted_energy(&self) -> Option<Energy> {
        self.energy_robust.or(self.energy)
    }

    fn half_step(&self) -> Option<HalfStep<'_>> {
        Some(HalfStep {
            loads: self.loads_half_step.as_ref()?,
            energy: self.energy_half_step?,
            own_energy: self.energy?,
        })
    }

    /// The time in which the robot walks, s, in a rollout of `seconds`: until it stands still.
    pub fn seconds_of_walk(&self, seconds: f64) -> f64 {
        let still = self.standstill.filter(|_| self.is_far());
        still.map_or(seconds, |still| still.since)
    }

    /// True if the robot is ranked by its displacement; see [`Loss::is_far`](crate::objective::Loss::is_far).
    pub fn is_far(&self) -> bool {
        self.loss_p50.is_none()
    }

    /// True if the robot is unreliable.
    pub fn is_unreliable(&self) -> bool {
        self.unreliable().is_some()
    }

    /// The numbers that a start is ranked by: the score, then the median to break ties. Minus infinity for a number
    /// that the summary lacks.
    pub fn rank(&self) -> [f64; 2] {
        let numbers = [
            self.displacement_selection_score,
            self.displacement_selection_p50,
        ];
        numbers.map(|x| x.unwrap_or(f64::NEG_INFINITY))
    }

    /// Summarises an optimisation of `scene` and its delivery. The name of the scene is empty and the wall time is 0: a run
    /// in a folder adds them.
    pub fn new(scene: &Scene, progress: &Progress, delivery: &Delivery) -> Self {
        let all = progress.iteration >= scene.schedule.iterations;
        let half_step = delivery.half_step.as_ref();
        let across = |of: fn(&Quantiles) -> f64| delivery.across.as_ref().map(of).and_then(finite);
        Self {
            scene: String::new(),
            seed: progress.seed,
            displacement: delivery.displacement.in_plane(),
            displacement_along: delivery.seen.moved.forward(),
            displacement_p10: finite(delivery.spread.p10),
            displacement_p50: finite(delivery.spread.p50),
            displacement_p90: finite(delivery.spread.p90),
            displacement_robust_p50: finite(delivery.robust.p50),
            displacement_robust_p10: finite(delivery.robust.p10),
            across_robust_p50: across(|quantiles| quantiles.p50),
            across_robust_p10: across(|quantiles| quantiles.p10),
            across_robust_p90: across(|quantiles| quantiles.p90),
            displacement_half_step_p50: finite(delivery.other_steps.half.displacement),
            displacement_integrator_p50: (delivery.other_steps.integrator)
                .and_then(|(_, medians)| finite(medians.displacement)),
            displacement_low_friction_p50: delivery.low_friction.and_then(finite),
            displacement_last_p50: finite(delivery.last.p50),
            displacement_clock_p50: finite(delivery.clock_alone.p50),
            displacement_selection_p50: finite(delivery.selection.p50),
            displacement_selection_score: finite(delivery.selection_score),
            reliability: delivery.reliability.clone(),
            standstill: delivery.seen.standstill,
            loss_p50: delivery.merit.map(|merit| finite(-merit.p50)),
            loss_idle_p50: delivery.idle_merit.and_then(|merit| finite(-merit.p50)),
            volume: delivery.seen.volume,
            actuator_volume: delivery.seen.actuator_volume,
            undecided: delivery.seen.structure.is_none(),
            structure: delivery.seen.structure,
            loads: delivery.seen.loads.clone(),
            energy: delivery.seen.energy,
            energy_robust: delivery.robust_energy,
            loads_half_step: half_step.map(|half| half.loads.clone()),
            energy_half_step: half_step.map(|half| half.energy),
            sensitivities: delivery.sensitivities.clone(),
            ways: delivery.ways.clone(),
            flips: progress.flips,
            skipped_gradients: progress.skipped,
            entered: progress.entered,
            iterations: progress.iteration - progress.before_first(),
            delivered_iteration: delivery.iteration,
            stop_reason: if all {
                StopReason::Finished
            } else {
                StopReason::Unfinished
            },
            cosmic_version: env!("CARGO_PKG_VERSION").to_string(),
            seconds: 0.0,
            starts: Vec::new(),
        }
    }
}
