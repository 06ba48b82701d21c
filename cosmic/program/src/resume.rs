//! `cosmic resume`.

use crate::arguments::Work;
use crate::runs;
use clap::Args;
use cosmic::error::{Error, Result};
use cosmic::record::summary::SUMMARY;
use cosmic::record::{allow_unstable, resume};
use std::path::PathBuf;

/// Go on with a run from its last snapshot; a finished one is left as it is
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The run's folder
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Go on although the time step became unstable for the robot
    #[arg(long)]
    allow_unstable: bool,
    #[command(flatten)]
    work: Work,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        if self.allow_unstable {
            allow_unstable(&self.run)?;
        }
        let is_finished = self.run.join(SUMMARY).exists();
        let done = runs::carry_out(&self.run, &self.work, |observer| {
            resume(&self.run, observer)
        });
        match done {
            // It was said when the run ended; now there is nothing to do, and that goes well.
            Err(Error::NoFigure(_)) if is_finished => Ok(()),
            done => done,
        }
    }
}
