//! `cosmic sweep`.

mod plan;
mod status;
mod run;
mod script;

use crate::arguments::Output;
use clap::{Args, Subcommand};
use cosmic::Registry;
use cosmic::error::Result;
use std::path::PathBuf;

/// Plan many runs and do them in any number of processes
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Write a plan of scenes, settings and seeds into a new folder
    Plan(plan::Plan),
    /// Do or continue all unfinished runs
    ///
    /// A run whose simulation diverges counts as done, with exit code 0; `status` and `merge` show the divergence.
    Run(run::Run),
    /// Show the state of every run
    Status {
        /// The folder of the sweep
        #[arg(value_name = "S")]
        sweep: PathBuf,
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
    /// Write results.json and results.csv of all finished runs
    Merge {
        /// The folder of the sweep
        #[arg(value_name = "S")]
        sweep: PathBuf,
        #[command(flatten)]
        output: Output,
    },
    /// Write a script that does the unfinished runs with Slurm, GNU parallel or Kubernetes
    Script(script::Script),
    /// Remove trajectories, histories and snapshots of finished runs; summaries and designs stay
    Prune {
        /// The folder of the sweep
        #[arg(value_name = "S")]
        sweep: PathBuf,
        #[command(flatten)]
        output: Output,
    },
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        match &self.action {
            Action::Plan(plan) => plan.freeze(registry),
            Action::Run(run) => run.run(registry),
            Action::Status { sweep, json } => status::status(sweep, *json),
            Action::Merge { sweep, output } => status::merge(sweep, output),
            Action::Script(script) => script.write(),
            Action::Prune { sweep, output } => status::prune(sweep, output),
        }
    }
}
