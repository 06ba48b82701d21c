//! The records of a study's runs, trial by trial.

use super::check::Check;
use super::statistics::{Statistics, median};
use super::trials::Trial;
use crate::sweep::{RunState, SweepPlan};
use cosmic::error::Result;
use cosmic::record::Summary;
use cosmic::scene::Departure;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// One run. Displacements in metres along the ground; `None` where a rollout diverged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRow {
    /// Its seed.
    pub seed: u64,
    /// Whether the delivered design flew apart; then the rest is empty.
    pub diverged: bool,
    /// What the run wrote last.
    pub summary: Option<Summary>,
    /// What was measured of it afterwards.
    pub check: Option<Check>,
}

impl RunRow {
    /// The figure to quote: the median over perturbed starts.
    pub fn displacement(&self) -> Option<f64> {
        self.summary.as_ref()?.displacement_p50
    }

    /// From the 10 % to the 90 % quantile over perturbed starts.
    pub fn spread(&self) -> Option<f64> {
        let summary = self.summary.as_ref()?;
        Some(summary.displacement_p90? - summary.displacement_p10?)
    }

    /// The same design at half the time step.
    pub fn half_step(&self) -> Option<f64> {
        self.check.as_ref()?.half_step[1]
    }
}

/// A trial over all its seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The trial's name in files.
    pub name: String,
    /// The table that it belongs to.
    pub table: String,
    /// What a reader calls it.
    pub title: String,
    /// The paper's displacement along the ground, m.
    pub paper: Option<f64>,
    /// Named options in force that differ from the paper.
    pub departures: Vec<Departure>,
    /// The displacements of all seeds.
    pub displacement: Statistics,
    /// The median over the paper's number.
    pub ratio: Option<f64>,
    /// The spread under perturbed starts, its median over the seeds.
    pub spread: Option<f64>,
    /// The displacement at half the time step, its median.
    pub half_step: Option<f64>,
    /// The last iterate's displacement, its median.
    pub last: Option<f64>,
    /// The displacement with the goal behind, its median.
    pub goal_behind: Option<f64>,
    /// The displacement of one unperturbed rollout in the world's frame, the medians of x and y.
    pub world: [Option<f64>; 2],
    /// The shares of solid edges and of actuators, their medians.
    pub volumes: [Option<f64>; 2],
    /// The wall time of a run on one thread, its median, s.
    pub seconds: Option<f64>,
    /// Runs whose edges have exactly one material each.
    pub one_hot: usize,
    /// Runs whose volumes are within the widened bounds.
    pub within_bounds: usize,
    /// Gradients skipped in all runs because they were not finite.
    pub skipped_gradients: usize,
    /// Every seed.
    pub runs: Vec<RunRow>,
}

impl Row {
    /// The run that got farthest; none where all diverged.
    pub fn best(&self) -> Option<&RunRow> {
        let farther = |best: Option<&RunRow>, run: &RunRow| {
            run.displacement() > best.and_then(RunRow::displacement)
        };
        self.runs
            .iter()
            .fold(None, |best, run| match farther(best, run) {
                true => Some(run),
                false => best,
            })
    }

    /// Every seed's displacement.
    pub fn sample(&self) -> Vec<f64> {
        self.runs.iter().filter_map(RunRow::displacement).collect()
    }

    fn new(trial: &Trial, runs: Vec<RunRow>) -> Self {
        let of = |number: &dyn Fn(&RunRow) -> Option<f64>| -> Vec<Option<f64>> {
            runs.iter().map(number).collect()
        };
        let summary = |number: fn(&Summary) -> Option<f64>| {
            median(&of(&|run| run.summary.as_ref().and_then(number)))
        };
        let count = |is: fn(&Check) -> bool| {
            let checks = runs.iter().filter_map(|run| run.check.as_ref());
            checks.filter(|check| is(check)).count()
        };
        let displacement = Statistics::of(&of(&RunRow::displacement));
        let skipped = runs.iter().filter_map(|run| run.summary.as_ref());
        Self {
            name: trial.name.clone(),
            table: trial.table.to_owned(),
            title: trial.title.to_owned(),
            paper: trial.paper,
            departures: trial.scene.departures(),
            ratio: Option::zip(displacement.median, trial.paper).map(|(own, paper)| own / paper),
            displacement,
            // What diverged spreads more than anything.
            spread: median(&of(&|run| Some(run.spread().unwrap_or(f64::INFINITY)))),
            half_step: median(&of(&RunRow::half_step)),
            last: summary(|s| s.displacement_last_p50),
            goal_behind: median(&of(&|run| run.check.as_ref()?.goal_behind)),
            world: [
                summary(|s| Some(s.displacement[0])),
                summary(|s| Some(s.displacement[1])),
            ],
            volumes: [
                summary(|s| Some(s.volume)),
                summary(|s| Some(s.actuator_volume)),
            ],
            seconds: summary(|s| Some(s.seconds)),
            one_hot: count(|check| check.one_hot),
            within_bounds: count(|check| check.within_bounds),
            skipped_gradients: skipped.map(|summary| summary.skipped_gradients).sum(),
            runs,
        }
    }
}

/// A trial's results with the folders of its runs, in the order of the seeds.
pub(super) struct Collected {
    pub(super) row: Row,
    pub(super) folders: Vec<PathBuf>,
}

impl Collected {
    /// The folder of the run that got farthest.
    pub(super) fn best_folder(&self) -> Option<&Path> {
        let best = self.row.best()?;
        let index = self.row.runs.iter().position(|run| run == best)?;
        Some(&self.folders[index])
    }
}

/// Reads the records of all runs.
///
/// # Errors
/// Where a record is missing or no good.
pub(super) fn collect(runs: &Path, plan: &SweepPlan, trials: &[Trial]) -> Result<Vec<Collected>> {
    let seeds = plan.seeds.get();
    let one = |index: usize| -> Result<RunRow> {
        let folder = plan.folder(runs, index);
        let diverged = RunState::of(&folder) == RunState::Diverged;
        let (_, seed) = plan.parts(index);
        let summary = (!diverged).then(|| Summary::read(&folder)).transpose()?;
        let check = (!diverged).then(|| Check::read(&folder)).transpose()?;
        Ok(RunRow {
            seed,
            diverged,
            summary,
            check,
        })
    };
    let trial = |(k, trial): (usize, &Trial)| {
        let indices = k * seeds..(k + 1) * seeds;
        let runs_of = indices.clone().map(one).collect::<Result<_>>()?;
        Ok(Collected {
            row: Row::new(trial, runs_of),
            folders: indices.map(|index| plan.folder(runs, index)).collect(),
        })
    };
    trials.iter().enumerate().map(trial).collect()
}
