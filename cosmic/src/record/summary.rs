//! `summary.json`, the last file that a run writes, and what to do if a file of the result is missing.

use super::files::{is_taken, no_run};
use super::snapshot::{SNAPSHOT, Snapshot};
use crate::error::{Error, Result, command, go_on, in_shell};
use crate::format::Format;
use std::io;
use std::path::{Path, PathBuf};

/// The format of a summary.
pub(super) const FORMAT: Format = Format::new("cosmic-summary", 1);

/// The name of the summary in the folder of a run. A run with a summary is finished.
pub const SUMMARY: &str = "summary.json";

/// The name of the file with the last states of a diverged result.
pub const DIVERGED: &str = "diverged.json";

/// The path of a file that a run writes when it ends.
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

/// Text that says why the run in a folder lacks a file of its result, and what the user can do.
fn unfinished(folder: &Path) -> String {
    let summary = folder.join(SUMMARY);
    if summary.exists() {
        let (summary, run) = (in_shell(&summary), in_shell(folder));
        let again = command(format_args!("resume {run}"));
        return format!(
            "the run is finished, but this file is missing; to write it again, delete {summary} and continue with: \
             {again}"
        );
    }
    let diverged = folder.join(DIVERGED);
    if diverged.exists() {
        let command = command(format_args!("evaluate {}", in_shell(&diverged)));
        return format!("the run diverged; see its last states with: {command}");
    }
    if is_taken(folder) {
        return "the run is not finished: a process is doing it; wait until it ends".to_owned();
    }
    let how = go_on(folder, Snapshot::has_own_loss(folder));
    format!("the run is not finished; {how}")
}
