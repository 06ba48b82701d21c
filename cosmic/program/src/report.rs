//! `cosmic report`.

use crate::arguments::Output;
use crate::output::{in_json, print, print_json};
use clap::Args;
use cosmic::error::Result;
use cosmic_lab::report::{self, Results};
use serde_json::json;
use std::path::PathBuf;

/// Draw a finished run: a page, pictures and an animation in its folder
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The run's folder
    #[arg(value_name = "RUN")]
    run: PathBuf,
    #[command(flatten)]
    output: Output,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let written = report::write(&Results::read(&self.run)?)?;
        if self.output.json {
            return print_json(&json!({ "written": in_json(&written) }));
        }
        if self.output.quiet {
            return Ok(());
        }
        let line = |path: &PathBuf| format!("{}\n", path.display());
        print(&written.iter().map(line).collect::<String>())
    }
}
