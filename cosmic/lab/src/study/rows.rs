//! The records of a study's runs, trial by trial.

use super::check::Check;
use super::in_mujoco::{OnFriction, Transfer, Tried};
use super::statistics::Statistics;
use super::trials::Trial;
use crate::sweep::{RunState, SweepPlan};
use cosmic::error::Result;
use cosmic::record::Summary;
use cosmic::scene::Departure;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// One run. Displacements in metres along the ground; `None` if a rollout diverged.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct RunRow {
    /// Its seed.
    pub(super) seed: u64,
    /// True if the delivered design diverged; then the rest is empty.
    pub(super) diverged: bool,
    /// The summary of the run.
    pub(super) summary: Option<Summary>,
    /// The numbers measured after the run.
    pub(super) check: Option<Check>,
    /// How far it gets in MuJoCo; of the study of transfer alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) transfer: Option<Transfer>,
    /// Its folder.
    #[serde(skip)]
    pub(super) folder: PathBuf,
}

impl RunRow {
    /// The median over perturbed starts: the figure to quote.
    pub(super) fn displacement(&self) -> Option<f64> {
        self.summary.as_ref()?.displacement_p50
    }

    /// True if the robot is known to be unreliable. Ratios to its displacement are then meaningless.
    pub(super) fn is_unreliable(&self) -> bool {
        self.summary.as_ref().is_some_and(Summary::is_unreliable)
    }

    /// The distance of the 10 % and the 90 % quantile over perturbed starts.
    pub(super) fn spread(&self) -> Option<f64> {
        let summary = self.summary.as_ref()?;
        Some(summary.displacement_p90? - summary.displacement_p10?)
    }

    /// The displacement at half the time step.
    pub(super) fn half_step(&self) -> Option<f64> {
        self.check.as_ref()?.half_step[1]
    }

    /// The displacement with the goal behind.
    pub(super) fn goal_behind(&self) -> Option<f64> {
        self.check.as_ref()?.goal_behind
    }
}

/// A trial over all its seeds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct TrialRow {
    /// The trial.
    #[serde(flatten)]
    pub(super) trial: Trial,
    /// Named options in force that differ from the paper.
    pub(super) departures: Vec<Departure>,
    /// The displacements of all seeds.
    pub(super) displacement: Statistics,
    /// The median over the paper's number.
    pub(super) ratio: Option<f64>,
    /// The spread under perturbed starts, its median over the seeds.
    pub(super) spread: Option<f64>,
    /// The displacement at half the time step, its median.
    pub(super) half_step: Option<f64>,
    /// The last iterate's displacement, its median.
    pub(super) last: Option<f64>,
    /// The displacement with the goal behind, its median.
    pub(super) goal_behind: Option<f64>,
    /// The displacement of one unperturbed rollout in the world's frame, the medians of x and y.
    pub(super) world: [Option<f64>; 2],
    /// The shares of solid edges and of actuators, their medians.
    pub(super) volumes: [Option<f64>; 2],
    /// The wall time of a run on one thread, its median, s.
    pub(super) seconds: Option<f64>,
    /// Runs whose edges have exactly one material each.
    pub(super) one_hot: usize,
    /// Runs whose volumes are within the widened bounds.
    pub(super) within_bounds: usize,
    /// Runs whose bars all hang together with the payload.
    pub(super) one_piece: usize,
    /// The open-loop displacement, without feedback, over the displacement; unreliable robots are left out.
    pub(super) clock_alone: Statistics,
    /// The largest strain of an actuator.
    pub(super) strain_peak: Statistics,
    /// Gradients skipped in all runs because they were not finite.
    pub(super) skipped_gradients: usize,
    /// How far robots get in MuJoCo, a row a friction; of the study of transfer alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) on_frictions: Vec<OnFriction>,
    /// Every seed.
    pub(super) runs: Vec<RunRow>,
}

impl TrialRow {
    /// The run that got farthest, the first of equals; `None` if all diverged.
    pub(super) fn best(&self) -> Option<&RunRow> {
        let runs = self.runs.iter().rev();
        let runs = runs.filter_map(|run| Some((run, run.displacement()?)));
        let farthest = runs.max_by(|(_, a), (_, b)| a.total_cmp(b));
        farthest.map(|(run, _)| run)
    }

    fn new(trial: &Trial, runs: Vec<RunRow>) -> Self {
        let statistics = |number: &dyn Fn(&RunRow) -> Option<f64>| {
            Statistics::of(&runs.iter().map(number).collect::<Vec<_>>())
        };
        let median = |number: &dyn Fn(&RunRow) -> Option<f64>| statistics(number).median;
        let summary = |number: &dyn Fn(&Summary) -> Option<f64>| {
            median(&|run| run.summary.as_ref().and_then(number))
        };
        let count = |is: fn(&Check) -> bool| {
            let checks = runs.iter().filter_map(|run| run.check.as_ref());
            checks.filter(|check| is(check)).count()
        };
        let displacement = statistics(&RunRow::displacement);
        let tried = runs.iter().map(|run| Tried {
            far: run.displacement(),
            unreliable: run.is_unreliable(),
            transfer: run.transfer.as_ref(),
        });
        let on_frictions = OnFriction::rows(&tried.collect::<Vec<_>>());
        let clock_keeps = |run: &RunRow| run.summary.as_ref()?.clock_keeps();
        let reliable = runs.iter().filter(|run| !run.is_unreliable());
        let summaries = runs.iter().filter_map(|run| run.summary.as_ref());
        Self {
            trial: trial.clone(),
            departures: trial.scene.departures(),
            ratio: Option::zip(displacement.median, trial.paper).map(|(own, paper)| own / paper),
            displacement,
            // A diverged run spreads more than any other.
            spread: median(&|run| Some(run.spread().unwrap_or(f64::INFINITY))),
            half_step: median(&RunRow::half_step),
            last: summary(&|s| s.displacement_last_p50),
            goal_behind: median(&RunRow::goal_behind),
            world: [0, 1].map(|k| summary(&|s| Some(s.displacement.array()[k]))),
            volumes: [0, 1].map(|k| summary(&|s| Some([s.volume, s.actuator_volume][k]))),
            seconds: summary(&|s| Some(s.seconds)),
            one_hot: count(|check| check.one_hot),
            within_bounds: count(|check| check.within_bounds),
            one_piece: summaries
                .clone()
                .filter(|s| s.structure.is_some_and(|s| s.pieces == 1))
                .count(),
            clock_alone: Statistics::of(&reliable.map(clock_keeps).collect::<Vec<_>>()),
            strain_peak: statistics(&|run| Some(run.summary.as_ref()?.loads.as_ref()?.strain.peak)),
            skipped_gradients: summaries.map(|summary| summary.skipped_gradients).sum(),
            on_frictions,
            runs,
        }
    }
}

/// Reads the records of all runs.
///
/// # Errors
/// If a record is missing or malformed.
pub(super) fn collect(sweep: &Path, plan: &SweepPlan, trials: &[Trial]) -> Result<Vec<TrialRow>> {
    let seeds = plan.seeds.get();
    let run = |index: usize| -> Result<RunRow> {
        let folder = plan.folder(sweep, index);
        let diverged = RunState::of(&folder) == RunState::Diverged;
        Ok(RunRow {
            seed: plan.parts(index).1,
            diverged,
            summary: (!diverged).then(|| Summary::read(&folder)).transpose()?,
            check: (!diverged).then(|| Check::read(&folder)).transpose()?,
            transfer: Transfer::read(&folder)?,
            folder,
        })
    };
    let row = |(k, trial): (usize, &Trial)| {
        let runs = (k * seeds..(k + 1) * seeds).map(run);
        Ok(TrialRow::new(trial, runs.collect::<Result<_>>()?))
    };
    trials.iter().enumerate().map(row).collect()
}
