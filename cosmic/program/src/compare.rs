//! `cosmic compare`.

use crate::output::{in_colour, print_as};
use clap::Args;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use cosmic_lab::report::Comparison;
use std::path::PathBuf;

/// Compare finished runs: a table of six columns, and a verdict on each robot; with --out, show the robots walking
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folders of the runs
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Also write an HTML page to this file, with the verdicts, the robots walking side by side and the tables
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Show all numbers in the table, not only the six columns
    #[arg(long)]
    all: bool,
    /// Write JSON to standard output: the folder, the summary and the verdict of each run
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
        print_as(
            self.json,
            &comparison,
            &comparison.to_text(self.all, in_colour),
        )
    }
}
