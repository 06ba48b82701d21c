//! `cosmic report`.

use crate::arguments::Output;
use crate::output::answer_written;
use clap::Args;
use cosmic::error::Result;
use cosmic_lab::report;
use std::path::PathBuf;

/// Draw a finished run, or a design alone: a page and pictures in its folder, of a run an animation
///
/// A design alone is a folder with design.json and scene.toml only, or a design's file with
/// scene.toml beside it.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The run's folder, or a design's folder or file
    #[arg(value_name = "RUN")]
    run: PathBuf,
    #[command(flatten)]
    output: Output,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let written = report::write(&self.run)?;
        answer_written(&self.output, &written)
    }
}
