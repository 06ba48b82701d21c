//! `summary.json`: the result of a run, written last.

use super::RunPlan;
use super::files::{no_run, read_json};
use super::format::Format;
use super::snapshot::{SNAPSHOT, Snapshot};
use crate::codesign::{Delivery, Progress, Reliability};
use crate::design::Structure;
use crate::error::{Error, Result, go_on, in_shell};
use crate::geometry::Vector;
use crate::scene::Departure;
use crate::simulator::Loads;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// The format of a summary.
pub const FORMAT: Format = Format::new("cosmic-summary", 1);

/// The name of the summary in the folder of a run. A folder with a summary is that of a finished run.
pub const SUMMARY: &str = "summary.json";

/// Where the last states of a diverged result are kept.
pub const DIVERGED: &str = "diverged.json";

/// The result of a run. Displacements are those of the payload, in metres; `None` if a rollout
/// diverged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// The name of the scene.
    pub scene: String,
    /// The seed.
    pub seed: u64,
    /// Displacement of the payload in one unperturbed rollout of the delivered design, m: x and y of the world.
    pub displacement: Vector<f64>,
    /// Displacement in that rollout along the ground, m.
    pub displacement_along: f64,
    /// 10 % quantile along the ground over perturbed starts.
    pub displacement_p10: Option<f64>,
    /// Median over these starts: the figure to quote. If it is `None`, `optimize` exits with 3.
    pub displacement_p50: Option<f64>,
    /// 90 % quantile over these starts.
    pub displacement_p90: Option<f64>,
    /// Median of the last iterate over these starts.
    pub displacement_last_p50: Option<f64>,
    /// Median over the starts of `displacement_p50` with the clock alone; `None` in files of earlier versions
    /// too.
    #[serde(default)]
    pub displacement_clock_p50: Option<f64>,
    /// With two goals: the median displacement with the goal behind, over the starts of
    /// `displacement_p50`. A negative displacement is towards that goal.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub displacement_behind_p50: Option<f64>,
    /// Median over the other starts that the delivered design was chosen by; for a task other than
    /// distance, the median of minus the loss. With two goals, the median merit for the goal that
    /// the robot does worse at.
    pub displacement_selection_p50: Option<f64>,
    /// The number that the best of several starts is chosen by: `displacement_selection_p50`, or the
    /// 10 % quantile if the robot is unreliable in those starts. Also `None` in files of earlier
    /// versions.
    #[serde(default)]
    pub displacement_selection_score: Option<f64>,
    /// Whether `displacement_p50` describes the robot; for a task other than distance, whether
    /// `loss_p50` does. `None` in files of earlier versions.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub reliability: Option<Reliability>,
    /// For a task other than distance: the median loss of the delivered design over the starts of
    /// `displacement_p50`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub loss_p50: Option<f64>,
    /// Share of solid edges.
    #[serde(rename = "V")]
    pub volume: f64,
    /// Share of actuators.
    #[serde(rename = "V_act")]
    pub actuator_volume: f64,
    /// True if the run ended before every edge had one material: there are no bars yet. `None` in
    /// files of earlier versions.
    #[serde(default)]
    pub undecided: Option<bool>,
    /// How the bars are connected; `None` for an undecided design and in files of earlier versions.
    #[serde(default)]
    pub structure: Option<Structure>,
    /// The loads of actuators and bars; `None` for an undecided design and in files of earlier
    /// versions.
    #[serde(default)]
    pub loads: Option<Loads>,
    /// Edges whose material after the snap is not the dominant one before it.
    pub flips: usize,
    /// Gradients skipped because they were not finite.
    pub skipped_gradients: usize,
    /// The iteration after which a given robot entered; `None` for the scene's start.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub entered: Option<usize>,
    /// Iterations done.
    pub iterations: usize,
    /// The iteration that produced the delivered controller.
    pub delivered_iteration: usize,
    /// Why the run ended.
    pub stop_reason: StopReason,
    /// Options in force that differ from the paper.
    pub departures: Vec<Departure>,
    /// Version of the program.
    pub cosmic_version: String,
    /// Wall time without interruptions, s; the sum over several starts.
    pub seconds: f64,
    /// The starts, if there are several; the summary is that of the best one.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub starts: Vec<Start>,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StopReason {
    /// All iterations of the scene are done.
    Finished,
    /// The limit of the plan is reached; the scene has more iterations.
    IterationLimit,
}

/// One of several starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Start {
    /// Its seed, and the name of its folder.
    pub seed: u64,
    /// The start's median over the perturbed starts that controllers are chosen by; `None` if it
    /// diverged.
    pub displacement_selection_p50: Option<f64>,
    /// The number that the best start was chosen by, as in its summary.
    #[serde(default)]
    pub displacement_selection_score: Option<f64>,
    /// The median over other perturbed starts.
    pub displacement_p50: Option<f64>,
    /// Whether this median describes the start's robot.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub reliability: Option<Reliability>,
    /// The iteration after which the search dropped it, or `None`.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub dropped_at: Option<usize>,
}

/// A number of a summary; `None` if a rollout diverged.
pub type SummaryNumber = fn(&Summary) -> Option<f64>;

/// The numbers of a summary in tables, each with the name of its column.
pub const NUMBERS: [(&str, SummaryNumber); 27] = [
    ("displacement_p50", |s| s.displacement_p50),
    ("displacement_p10", |s| s.displacement_p10),
    ("displacement_p90", |s| s.displacement_p90),
    ("displacement_last_p50", |s| s.displacement_last_p50),
    ("displacement_clock_p50", |s| s.displacement_clock_p50),
    ("displacement_along", |s| Some(s.displacement_along)),
    ("displacement_x", |s| Some(s.displacement.forward())),
    ("displacement_y", |s| Some(s.displacement.up())),
    ("V", |s| Some(s.volume)),
    ("V_act", |s| Some(s.actuator_volume)),
    ("pieces", |s| s.structure.map(|s| s.pieces as f64)),
    ("nodes", |s| s.structure.map(|s| s.nodes as f64)),
    ("free_ends", |s| s.structure.map(|s| s.free_ends as f64)),
    ("crossings", |s| s.structure.map(|s| s.crossings as f64)),
    ("feet", |s| s.structure.map(|s| s.feet as f64)),
    ("floppy_modes", |s| {
        s.structure
            .and_then(|s| s.floppy_modes)
            .map(|modes| modes as f64)
    }),
    ("strain_peak", |s| s.loads.as_ref().map(|l| l.strain.peak)),
    ("strain_p99", |s| s.loads.as_ref().map(|l| l.strain.p99)),
    ("force_peak", |s| s.loads.as_ref().map(|l| l.force.peak)),
    ("speed_peak", |s| s.loads.as_ref().map(|l| l.speed.peak)),
    ("power_peak", |s| s.loads.as_ref().map(|l| l.power.peak)),
    ("compression", |s| s.loads.as_ref().map(|l| l.compression)),
    ("tangled", |s| s.loads.as_ref().map(|l| l.tangled)),
    ("flips", |s| (!s.is_undecided()).then_some(s.flips as f64)),
    ("skipped_gradients", |s| Some(s.skipped_gradients as f64)),
    ("delivered_iteration", |s| {
        Some(s.delivered_iteration as f64)
    }),
    ("seconds", |s| Some(s.seconds)),
];

/// The ratio of two displacements. `None` if the ratio means nothing, because the divisor is below a
/// centimetre (the robot stays in place) or because the robot walks backwards.
pub fn ratio(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    let (a, b) = (a.filter(|a| *a >= 0.0), b.filter(|b| *b >= 0.01));
    Option::zip(a, b).map(|(a, b)| a / b)
}

impl Summary {
    /// The [`ratio`] of a robot's open-loop displacement, without feedback, to its displacement. Also
    /// `None` for an unreliable robot.
    pub fn clock_keeps(&self) -> Option<f64> {
        let whole = self.displacement_p50.filter(|_| !self.is_unreliable());
        ratio(self.displacement_clock_p50, whole)
    }

    /// True for a design that is known to be undecided.
    pub fn is_undecided(&self) -> bool {
        self.undecided == Some(true)
    }

    /// Why the robot is unreliable; `None` for a reliable one, and in files of earlier versions.
    pub fn unreliable(&self) -> Option<&str> {
        self.reliability.as_ref()?.reason()
    }

    /// Whether the robot is reliable, in one word; `None` in files of earlier versions.
    pub fn verdict(&self) -> Option<&'static str> {
        self.reliability.as_ref().map(Reliability::word)
    }

    /// True for a robot that is known to be unreliable.
    pub fn is_unreliable(&self) -> bool {
        self.unreliable().is_some()
    }

    /// The number that the best of several starts is chosen by; the median for files of earlier
    /// versions.
    pub(super) fn score(&self) -> Option<f64> {
        match self.reliability {
            Some(_) => self.displacement_selection_score,
            None => self.displacement_selection_p50,
        }
    }

    pub(super) fn new(
        plan: &RunPlan,
        progress: &Progress,
        delivery: &Delivery,
        seconds: f64,
    ) -> Self {
        let finite = |x: f64| x.is_finite().then_some(x);
        let all = progress.iteration >= plan.scene.schedule.iterations;
        Self {
            scene: plan.name.clone(),
            seed: progress.seed,
            displacement: delivery.displacement,
            displacement_along: delivery.along,
            displacement_p10: finite(delivery.spread.p10),
            displacement_p50: finite(delivery.spread.p50),
            displacement_p90: finite(delivery.spread.p90),
            displacement_last_p50: finite(delivery.last.p50),
            displacement_clock_p50: finite(delivery.clock_alone.p50),
            displacement_behind_p50: delivery.behind.and_then(|behind| finite(behind.p50)),
            displacement_selection_p50: finite(delivery.selection.p50),
            displacement_selection_score: finite(delivery.selection_score),
            reliability: Some(delivery.reliability.clone()),
            loss_p50: delivery.merit.and_then(|merit| finite(-merit.p50)),
            volume: delivery.volume,
            actuator_volume: delivery.actuator_volume,
            undecided: Some(delivery.structure.is_none()),
            structure: delivery.structure,
            loads: delivery.loads.clone(),
            flips: progress.flips,
            skipped_gradients: progress.skipped,
            entered: progress.entered,
            iterations: progress.iteration - progress.before_first(),
            delivered_iteration: delivery.iteration,
            stop_reason: if all {
                StopReason::Finished
            } else {
                StopReason::IterationLimit
            },
            departures: departures(plan, progress),
            cosmic_version: env!("CARGO_PKG_VERSION").to_string(),
            seconds,
            starts: Vec::new(),
        }
    }

    /// The summary of a finished run.
    ///
    /// # Errors
    /// The errors of [`read_json`]; [`Error::Read`] for a run that is not finished.
    pub fn read(folder: &Path) -> Result<Self> {
        read_json(&result_of(folder, SUMMARY)?, FORMAT)
    }
}

/// The path of a file that a run writes at its end.
///
/// # Errors
/// [`Error::Read`] for a run that is not finished, and for a folder that is not a run.
pub fn result_of(folder: &Path, name: &str) -> Result<PathBuf> {
    let path = folder.join(name);
    if path.exists() {
        return Ok(path);
    }
    if !folder.join(SNAPSHOT).exists() {
        return Err(no_run(folder, name));
    }
    Err(Error::reading(path)(io::Error::other(unfinished(folder))))
}

/// Why a run has no result, and what to do.
fn unfinished(folder: &Path) -> String {
    let diverged = folder.join(DIVERGED);
    if diverged.exists() {
        let command = format!("cosmic evaluate {}", in_shell(&diverged));
        return format!("the run diverged; see its last states with: {command}");
    }
    let how = go_on(folder, Snapshot::has_own_loss(folder));
    format!("the run is not finished; {how}")
}

/// The options in force that differ from the paper: those of the scene that the run used, and those
/// that no scene can express.
fn departures(plan: &RunPlan, progress: &Progress) -> Vec<Departure> {
    let schedule = &plan.scene.schedule;
    let decided_before = progress
        .entered
        .is_some_and(|entered| entered == schedule.snap_at);
    let idle = |option: &str| {
        let of_start = progress.entered.is_some() && option.starts_with("start.");
        let of_design = decided_before
            && [
                "gradient.design_memory",
                "schedule.snap_trials",
                "schedule.stability_share",
                "schedule.cycle",
                "materials.penalisation",
                "projection.hold_materials",
                "binarisation.method",
            ]
            .contains(&option);
        let of_loss = progress.own_loss
            && ["loss.", "objective."]
                .iter()
                .any(|s| option.starts_with(s));
        of_start || of_design || of_loss
    };
    let mut departures = plan.scene.departures();
    departures.retain(|departure| !idle(&departure.option));
    let named = |option: &str, says: &str| Departure {
        option: option.to_string(),
        says: says.to_string(),
    };
    if progress.entered.is_some() {
        let says = "the run began with a robot that was there already, kept in start.json";
        departures.push(named("start", says));
    }
    if progress.own_loss {
        let says = "robots are designed for a loss of the program that began the run";
        departures.push(named("loss", says));
    }
    departures
}
