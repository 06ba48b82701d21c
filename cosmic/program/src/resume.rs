//! `cosmic resume`.

use crate::arguments::Output;
use crate::runs;
use clap::Args;
use cosmic::error::{Error, Result};
use cosmic::record::summary::SUMMARY;
use cosmic::record::{allow_unstable, resume};
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// Go on with a run from its last snapshot; a finished one is left as it is
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The run's folder
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Threads, 1024 at most; the results do not depend on their number
    #[arg(long, value_name = "N", value_parser = crate::arguments::threads)]
    threads: Option<NonZeroUsize>,
    /// Go on although the time step became unstable for the robot
    #[arg(long)]
    allow_unstable: bool,
    #[command(flatten)]
    output: Output,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        if self.allow_unstable {
            allow_unstable(&self.run)?;
        }
        let is_finished = self.run.join(SUMMARY).exists();
        let done = runs::carry_out(&self.run, self.threads, &self.output, |observer| {
            resume(&self.run, observer)
        });
        match done {
            // It was said when the run ended; now there is nothing to do, and that goes well.
            Err(Error::NoFigure(_)) if is_finished => Ok(()),
            done => done,
        }
    }
}
