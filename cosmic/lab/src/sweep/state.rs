//! The state of a sweep's run, judged by its files.

use cosmic::record::DIVERGED;
use cosmic::record::history::LINES;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use serde::Serialize;
use std::fs;
use std::path::Path;

/// The state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// Not begun.
    Waiting,
    /// At work, or interrupted.
    Begun,
    /// Finished, with a summary.
    Done,
    /// Finished, with a design that diverges.
    Diverged,
}

impl RunState {
    /// All states, in order.
    pub const ALL: [Self; 4] = [Self::Waiting, Self::Begun, Self::Done, Self::Diverged];

    /// The state of a run's folder, which need not exist.
    pub fn of(folder: &Path) -> Self {
        if folder.join(SUMMARY).exists() {
            RunState::Done
        } else if folder.join(DIVERGED).exists() {
            RunState::Diverged
        } else if folder.join(SNAPSHOT).exists() {
            RunState::Begun
        } else {
            RunState::Waiting
        }
    }

    /// True if nothing is left to do.
    pub fn is_over(self) -> bool {
        matches!(self, RunState::Done | RunState::Diverged)
    }

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            RunState::Waiting => "waiting",
            RunState::Begun => "begun",
            RunState::Done => "done",
            RunState::Diverged => "diverged",
        }
    }
}

/// Iterations in a run's history. A run at work may be one ahead.
pub(super) fn iterations(folder: &Path) -> usize {
    let bytes = fs::read(folder.join(LINES)).unwrap_or_default();
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}
