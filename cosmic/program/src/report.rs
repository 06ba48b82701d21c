//! `cosmic report`.

use crate::arguments::Output;
use crate::output::{answer, answer_written, in_colour, note};
use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::record::files::write_atomic;
use cosmic::record::run::read_summary;
use cosmic_lab::report::{self, Comparison, verdict_of};
use std::path::{Path, PathBuf};

/// Make a page, a picture and an animation of a finished run in its folder; or compare several runs
///
/// RUN can also be a design without a run: a folder with only design.json and scene.toml, or a design file with
/// scene.toml beside it. Such a design gets only a page.
///
/// Several runs are compared in a table of six columns, with a verdict on each robot. --out writes a page that shows the
/// robots walking side by side; of one run, it writes the page of the run, and nothing in the folder of the run.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folder of a run, or the folder or file of a design; or the folders of several runs
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Write only an HTML page, to this file. Of several runs it has the verdicts, the robots in motion and the tables
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Of several runs, show all numbers in the table, not only the six columns
    #[arg(long)]
    all: bool,
    #[command(flatten)]
    output: Output,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let [run] = &self.runs[..] else {
            return self.compare(registry);
        };
        if self.all {
            return Err(Error::Usage(
                "--all is for several runs; name at least two".into(),
            ));
        }
        let written = match &self.out {
            None => report::write(run, registry)?,
            Some(file) => {
                report::write_page(run, file, registry)?;
                vec![file.clone()]
            }
        };
        if !self.output.json {
            note_verdict(run, registry);
        }
        answer_written(&self.output, &written)
    }

    /// Prints a table of the runs, and writes the page of the comparison if it is asked for.
    fn compare(&self, registry: &Registry) -> Result<()> {
        let comparison = Comparison::read(&self.runs, registry)?;
        if let Some(path) = &self.out {
            let page = comparison.to_html(registry)?;
            write_atomic(path, |file| file.write_all(page.as_bytes()))?;
        }
        let text = comparison.to_text(self.all, in_colour);
        answer(&self.output, &comparison, &text)
    }
}

/// Prints the verdict on standard error, if this is a run.
fn note_verdict(run: &Path, registry: &Registry) {
    if let Ok(summary) = read_summary(run)
        && let Ok(verdict) = verdict_of(run, &summary, registry)
    {
        note(&format!("verdict: {}", verdict.to_text()));
    }
}
