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

/// Many runs from a frozen plan, shared by any number of processes
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Fix scenes, settings and seeds in a new folder
    Plan(plan::Plan),
    /// Do the runs that are not done, or go on with them, until none is left
    ///
    /// A run whose simulation diverges is done as well, with exit code 0: that is its result, which
    /// `status` and `merge` give.
    Run(run::Run),
    /// Say how far every run is
    Status {
        /// The sweep's folder
        #[arg(value_name = "S")]
        sweep: PathBuf,
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
    /// Write results.json and results.csv from the runs that are done
    Merge {
        /// The sweep's folder
        #[arg(value_name = "S")]
        sweep: PathBuf,
        #[command(flatten)]
        output: Output,
    },
    /// Write what hands the runs that are left to Slurm, GNU parallel or Kubernetes
    Script(script::Script),
    /// Remove trajectories, histories and snapshots of runs that are over; summaries and designs stay
    Prune {
        /// The sweep's folder
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
