//! `cosmic sweep script`.

use crate::arguments::{count, whole};
use crate::output::{lines, print};
use clap::Args;
use cosmic::error::{Error, Result};
use cosmic::record::files::write_atomic;
use cosmic_lab::sweep::{HandOver, PlanOutline, Scheduler, survey};
use std::num::NonZeroUsize;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Script {
    /// The folder of the sweep
    #[arg(value_name = "S")]
    sweep: PathBuf,
    #[command(flatten)]
    scheduler: Which,
    /// Maximum number of tasks at the same time
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    throttle: Option<NonZeroUsize>,
    /// Time limit of a task in minutes; its runs are saved a minute earlier
    #[arg(long, value_name = "M", value_parser = whole(2..=1_000_000_u64), allow_negative_numbers = true)]
    minutes: Option<u64>,
    /// Runs per task, one after the other on its cores [default: the number of cores]
    #[arg(long, value_name = "K", value_parser = count, allow_negative_numbers = true)]
    seeds_per_task: Option<NonZeroUsize>,
    /// Cores per task; each core does one run at a time
    #[arg(long, value_name = "N", default_value = "1", value_parser = count, allow_negative_numbers = true)]
    cores: NonZeroUsize,
    /// Write to this file instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[group(required = true, multiple = false)]
struct Which {
    /// Write a batch script for `sbatch`: an array of tasks
    #[arg(long)]
    slurm: bool,
    /// Write a script that runs GNU parallel on this machine
    #[arg(long)]
    parallel: bool,
    /// Write the manifest of an indexed Job for `kubectl apply`
    #[arg(long)]
    kubernetes: bool,
}

impl Script {
    pub(super) fn write(&self) -> Result<()> {
        let plan = PlanOutline::read(&self.sweep)?;
        let left = survey(&self.sweep, &plan).left();
        if left.is_empty() {
            let sweep = self.sweep.display();
            return Err(Error::Usage(format!("{sweep}: all runs are finished")));
        }
        let hand_over = HandOver {
            sweep: &self.sweep,
            runs: plan.runs(),
            left: &left,
            per_task: self.seeds_per_task.unwrap_or(self.cores),
            cores: self.cores,
            throttle: self.throttle,
            minutes: self.minutes,
        };
        let text = hand_over.script(self.scheduler.chosen())?;
        match &self.out {
            None => print(&text),
            Some(path) => {
                write_atomic(path, |file| file.write_all(text.as_bytes()))?;
                print(&lines(&[path]))
            }
        }
    }
}

impl Which {
    fn chosen(&self) -> Scheduler {
        if self.slurm {
            Scheduler::Slurm
        } else if self.parallel {
            Scheduler::Parallel
        } else {
            Scheduler::Kubernetes
        }
    }
}
