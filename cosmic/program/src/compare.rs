//! `cosmic compare`.

use crate::output::print_as;
use clap::Args;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use cosmic_lab::report::Comparison;
use std::path::PathBuf;

/// Show the summaries of finished runs side by side, and with --out the robots walking
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The runs' folders
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Write a page of HTML to this file as well: the robots in lanes on one ground, and the table
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write JSON to standard output: each run's folder and its summary
    #[arg(long)]
    json: bool,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let comparison = Comparison::read(&self.runs, registry)?;
        if let Some(path) = &self.out {
            let page = comparison.to_html(registry)?;
            write_atomic(path, |file| file.write_all(page.as_bytes()))?;
        }
        print_as(self.json, &comparison, &comparison.to_text())
    }
}
