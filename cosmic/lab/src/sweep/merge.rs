//! `results.json` and `results.csv`: the results of all runs, from their records.

use super::state::iterations;
use super::{RunState, SweepPlan};
use crate::files::write_text;
use crate::table::{Cell, Table};
use cosmic::error::Result;
use cosmic::record::Summary;
use cosmic::record::files::{Format, write_json};
use cosmic::record::summary::{NUMBERS, SummaryNumber};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The format of merged results.
pub(super) const FORMAT: Format = Format {
    name: "cosmic-sweep-results",
    version: 1,
};

/// The result of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MergedRun {
    /// Its number in the plan.
    pub index: usize,
    /// Its scene's name.
    pub scene: String,
    /// Its seed.
    pub seed: u64,
    /// Its state.
    pub state: RunState,
    /// Iterations done.
    pub iterations: usize,
    /// Its summary, if it is done.
    pub summary: Option<Summary>,
}

/// The runs of a sweep, in the plan's order.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SweepResults {
    /// One entry per run.
    pub runs: Vec<MergedRun>,
}

impl SweepResults {
    /// The number of runs in a state.
    pub fn count(&self, state: RunState) -> usize {
        self.runs.iter().filter(|run| run.state == state).count()
    }

    /// The number of runs that are not over.
    pub fn left(&self) -> usize {
        self.count(RunState::Waiting) + self.count(RunState::Begun)
    }
}

/// The states of a sweep's runs, without their summaries.
pub fn survey(sweep: &Path, plan: &SweepPlan) -> SweepResults {
    let one = |index: usize| {
        let folder = plan.folder(sweep, index);
        let (scene, seed) = plan.parts(index);
        MergedRun {
            index,
            scene: scene.name.clone(),
            seed,
            state: RunState::of(&folder),
            iterations: iterations(&folder),
            summary: None,
        }
    };
    let runs = (0..plan.runs()).map(one).collect();
    SweepResults { runs }
}

/// The states of a sweep's runs, with the summaries of those that are done.
///
/// # Errors
/// The errors of [`Summary::read`].
pub fn merge(sweep: &Path, plan: &SweepPlan) -> Result<SweepResults> {
    let mut results = survey(sweep, plan);
    for run in &mut results.runs {
        if run.state == RunState::Done {
            let summary = Summary::read(&plan.folder(sweep, run.index))?;
            run.iterations = summary.iterations;
            run.summary = Some(summary);
        }
    }
    Ok(results)
}

/// Writes a sweep's merged results into its folder and returns the paths.
///
/// # Errors
/// [`Error::Write`](cosmic::Error::Write).
pub fn write_results(sweep: &Path, results: &SweepResults) -> Result<[PathBuf; 2]> {
    let [json, csv] = ["results.json", "results.csv"].map(|name| sweep.join(name));
    write_json(&json, FORMAT, results)?;
    write_text(&csv, &table(results).to_csv())?;
    Ok([json, csv])
}

/// A row per run; a number that a run lacks is left empty.
fn table(results: &SweepResults) -> Table {
    let loss: (_, SummaryNumber) = ("loss_p50", |summary| summary.loss_p50);
    let numbers: Vec<_> = NUMBERS.into_iter().chain([loss]).collect();
    let names = numbers.iter().map(|(name, _)| *name);
    let number = |run: &MergedRun, k: usize| run.summary.as_ref().and_then(numbers[k].1);
    Table::of("", "", &results.runs)
        .column("index", "", |run| run.index)
        .column("scene", "", |run| &run.scene[..])
        .column("seed", "", |run| Cell::Count(run.seed))
        .column("state", "", |run| run.state.name())
        .column("iterations", "", |run| run.iterations)
        .columns(names, "", number)
        .decimals(3, "-")
        .done()
}
