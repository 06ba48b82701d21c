//! `cosmic resume`.

use crate::arguments::Work;
use crate::runs;
use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::record::summary::SUMMARY;
use cosmic::record::{allow_unstable, resume};
use std::path::PathBuf;

/// Continue a run from its last snapshot; a finished run stays as it is
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The run's folder
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Continue although the time step became unstable for the robot
    #[arg(long)]
    allow_unstable: bool,
    #[command(flatten)]
    work: Work,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        if self.allow_unstable {
            allow_unstable(&self.run, registry)?;
        }
        let is_finished = self.run.join(SUMMARY).exists();
        let done = runs::carry_out(&self.run, registry, &self.work, Vec::new(), |observer| {
            resume(&self.run, registry, observer)
        });
        match done {
            // A finished run already reported that its median diverged. This is no error when it is resumed.
            Err(Error::NoFigure(_)) if is_finished => Ok(()),
            done => done,
        }
    }
}
