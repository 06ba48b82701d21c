//! How far a run of a sweep is, by the files it has.

use cosmic::record::DIVERGED;
use cosmic::record::history::LINES;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use serde::Serialize;
use std::fs;
use std::path::Path;

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// Not begun.
    Waiting,
    /// Begun: at work, or interrupted.
    Begun,
    /// Finished, with a summary.
    Done,
    /// Finished: the delivered design flies apart.
    Diverged,
}

impl RunState {
    /// All of them, from the first on.
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

    /// Whether nothing is left to do.
    pub fn is_over(self) -> bool {
        matches!(self, RunState::Done | RunState::Diverged)
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            RunState::Waiting => "waiting",
            RunState::Begun => "begun",
            RunState::Done => "done",
            RunState::Diverged => "diverged",
        }
    }
}

/// Iterations in a run's history; a run at work may be one ahead.
pub(super) fn iterations(folder: &Path) -> usize {
    let bytes = fs::read(folder.join(LINES)).unwrap_or_default();
    bytes.iter().filter(|&&byte| byte == b'\n').count()
}
