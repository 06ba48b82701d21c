//! Options that several commands share.

use clap::Args;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// The most threads that are started: starting more takes longer than a run.
const MOST_THREADS: usize = 1024;

/// Reads how many threads to start.
pub(super) fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let number = text.parse().ok();
    let number = number.filter(|number: &NonZeroUsize| number.get() <= MOST_THREADS);
    number.ok_or_else(|| format!("a whole number from 1 to {MOST_THREADS} belongs here"))
}

/// How a command speaks.
#[derive(Debug, Clone, Args)]
pub(super) struct Output {
    /// Say nothing but errors
    #[arg(long, short)]
    pub(super) quiet: bool,
    /// Write JSON to standard output
    #[arg(long)]
    pub(super) json: bool,
}

/// What a command that simulates for long can be told.
#[derive(Debug, Clone, Args)]
pub(super) struct RunOptions {
    /// Seed of the random generator
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) seed: u64,
    /// Folder for the results, new or empty [default: runs/SCENE-SEED, with --from NAME and no
    /// SCENE runs/NAME-on]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Threads, 1024 at most; the results do not depend on their number
    #[arg(long, value_name = "N", value_parser = threads)]
    pub(super) threads: Option<NonZeroUsize>,
    /// How the command speaks.
    #[command(flatten)]
    pub(super) output: Output,
}
