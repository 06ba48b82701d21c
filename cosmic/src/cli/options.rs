//! Options that several commands share.

use clap::Args;
use std::path::PathBuf;

/// How a command speaks.
#[derive(Debug, Clone, Args)]
pub struct Output {
    /// Say nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Write JSON to standard output
    #[arg(long)]
    pub json: bool,
}

/// What a command that simulates for long can be told.
#[derive(Debug, Clone, Args)]
pub struct RunOptions {
    /// Seed of the random generator
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Folder for the results, new or empty [default: runs/SCENE-SEED, with --from NAME and no
    /// SCENE runs/NAME-on]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Threads; the results do not depend on their number
    #[arg(long, value_name = "N")]
    pub threads: Option<std::num::NonZeroUsize>,
    /// How the command speaks.
    #[command(flatten)]
    pub output: Output,
}
