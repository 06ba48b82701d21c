//! The numbers of a study's runs, and of its trials over all seeds.

use super::file::Trial;
use crate::statistics::Statistics;
use std::path::PathBuf;

/// The column with the median displacement over perturbed starts, m: the number to quote.
pub(super) const DISPLACEMENT: &str = "displacement_p50";

/// One run.
#[derive(Clone, Debug)]
pub(super) struct Run {
    pub(super) seed: u64,
    pub(super) folder: PathBuf,
    /// A number for each column: NaN if a rollout diverged, `None` if statistics leave it out.
    pub(super) numbers: Vec<(String, Option<f64>)>,
}

impl Run {
    /// The number of a column; `None` if a rollout diverged or statistics leave it out.
    pub(super) fn number(&self, column: &str) -> Option<f64> {
        let found = self.numbers.iter().find(|(name, _)| name == column)?;
        found.1.filter(|x| x.is_finite())
    }
}

/// A trial over all its seeds.
#[derive(Clone, Debug)]
pub(super) struct TrialRow {
    pub(super) trial: Trial,
    pub(super) runs: Vec<Run>,
}

impl TrialRow {
    /// The numbers of a column, without those that statistics leave out.
    pub(super) fn sample(&self, column: &str) -> Vec<f64> {
        let number = |run: &Run| run.numbers.iter().find(|(name, _)| name == column)?.1;
        self.runs.iter().filter_map(number).collect()
    }

    /// The statistics of a column.
    pub(super) fn of(&self, column: &str) -> Statistics {
        Statistics::of(&self.sample(column))
    }

    /// The run that got farthest, the first of equals; `None` if all diverged.
    pub(super) fn best(&self) -> Option<&Run> {
        let runs = self.runs.iter().rev();
        let runs = runs.filter_map(|run| Some((run, run.number(DISPLACEMENT)?)));
        let farthest = runs.max_by(|(_, a), (_, b)| a.total_cmp(b));
        farthest.map(|(run, _)| run)
    }
}
