//! The state of a run of a sweep, which its files determine.

use cosmic::record::DIVERGED;
use cosmic::record::history::LINES;
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::summary::SUMMARY;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// The state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// Not started.
    Waiting,
    /// Running or interrupted.
    Begun,
    /// Finished, with a summary.
    Done,
    /// Finished, but the robot of the result diverges.
    Diverged,
}

impl RunState {
    /// All states, in order.
    pub const ALL: [Self; 4] = [Self::Waiting, Self::Begun, Self::Done, Self::Diverged];

    /// The state of the run in this folder. The folder need not exist.
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

    /// True if the run is finished.
    pub fn is_over(self) -> bool {
        matches!(self, RunState::Done | RunState::Diverged)
    }

    /// The name of the state in files.
    pub fn name(self) -> &'static str {
        match self {
            RunState::Waiting => "waiting",
            RunState::Begun => "begun",
            RunState::Done => "done",
            RunState::Diverged => "diverged",
        }
    }
}

/// Returns the number of iterations that a run has done. The summary of a finished run states it; otherwise it is read
/// from the history. A run in progress may be one iteration further. Returns 0 if the file cannot be read.
pub fn iterations(folder: &Path, state: RunState) -> usize {
    match state {
        RunState::Waiting => None,
        RunState::Done => in_summary(folder),
        RunState::Begun | RunState::Diverged => in_history(folder),
    }
    .unwrap_or(0)
}

/// The number of iterations in a summary or in a row of a history.
#[derive(Deserialize)]
struct Counted {
    #[serde(alias = "iteration")]
    iterations: usize,
}

fn in_summary(folder: &Path) -> Option<usize> {
    let counted: Counted = serde_json::from_slice(&fs::read(folder.join(SUMMARY)).ok()?).ok()?;
    Some(counted.iterations)
}

/// The number of bytes to read from the end of a history. No row is longer.
const ROW: u64 = 1 << 14;

/// Reads the number of iterations from the last row of a history. Reads only the end of the file, because the histories
/// of a sweep may have gigabytes.
fn in_history(folder: &Path) -> Option<usize> {
    let mut file = File::open(folder.join(LINES)).ok()?;
    let length = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(ROW)))
        .ok()?;
    let mut end = Vec::new();
    file.read_to_end(&mut end).ok()?;
    // Text after the last line break belongs to a row that is still being written.
    let whole = &end[..end.iter().rposition(|&byte| byte == b'\n')?];
    let row = whole.rsplit(|&byte| byte == b'\n').next()?;
    let counted: Counted = serde_json::from_slice(row).ok()?;
    Some(counted.iterations)
}
