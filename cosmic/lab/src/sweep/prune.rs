//! Removes files of finished runs to save disk space; their results stay.

use super::{RunState, SweepPlan};
use cosmic::error::{Error, Result};
use cosmic::record::history::{DESIGNS, LINES};
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::trajectory_file::TRAJECTORY;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// What [`prune`] has removed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pruned {
    /// The number of runs that had files to remove.
    pub runs: usize,
    /// The total size of the removed files, in bytes.
    pub bytes: u64,
}

/// Removes trajectories, snapshots and histories of finished runs. Scenes, designs and summaries stay. The histories of
/// two kinds of runs also stay:
///
/// - Of a diverged run, only the history tells the number of iterations.
/// - The figures of a study are drawn from the histories of its runs.
///
/// # Errors
/// [`Error::Write`] for a file that cannot be removed.
pub fn prune(sweep: &Path, plan: &SweepPlan) -> Result<Pruned> {
    let mut pruned = Pruned::default();
    for index in 0..plan.runs() {
        let folder = plan.folder(sweep, index);
        let histories: &[&str] = match RunState::of(&folder) {
            RunState::Waiting | RunState::Begun => continue,
            RunState::Done if plan.study.is_none() => &[LINES, DESIGNS],
            RunState::Done | RunState::Diverged => &[],
        };
        let mut bytes = 0;
        for name in [TRAJECTORY, SNAPSHOT].iter().chain(histories) {
            bytes += removed(&folder.join(name))?;
        }
        pruned.runs += usize::from(bytes > 0);
        pruned.bytes += bytes;
    }
    Ok(pruned)
}

/// Removes a file, if it exists, and returns its size.
fn removed(path: &Path) -> Result<u64> {
    let size = match fs::symlink_metadata(path) {
        Ok(found) => found.len(),
        Err(source) if source.kind() == ErrorKind::NotFound => return Ok(0),
        Err(source) => return Err(Error::writing(path)(source)),
    };
    fs::remove_file(path).map_err(Error::writing(path))?;
    Ok(size)
}
