//! What hands the runs that are left to the engine of a cluster: scripts and a manifest, plain enough to edit.
//!
//! A task does one run, or several that follow one another. An engine that gives a task only so much time first
//! sends a signal, on which the runs save themselves; the exit code is then 75, and the task queues again.

mod task;
mod slurm;
mod parallel;
mod kubernetes;

use cosmic::error::Result;
use cosmic::record::files::make_folder;
use std::num::NonZeroUsize;
use std::path::Path;
use task::Tasks;

/// An engine that runs tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduler {
    /// Slurm, by an array of tasks.
    Slurm,
    /// GNU parallel, on one machine.
    Parallel,
    /// Kubernetes, by an indexed Job.
    Kubernetes,
}

/// The runs that are handed over, and how.
#[derive(Clone, Copy, Debug)]
pub struct HandOver<'s> {
    /// The sweep's folder, as the tasks find it.
    pub sweep: &'s Path,
    /// The number of runs in the plan.
    pub runs: usize,
    /// The runs that are left, at least one.
    pub left: &'s [usize],
    /// Runs per task.
    pub per_task: NonZeroUsize,
    /// Cores per task, with a run on each.
    pub cores: NonZeroUsize,
    /// The most tasks at a time.
    pub throttle: Option<NonZeroUsize>,
    /// The time limit of a task.
    pub minutes: Option<u64>,
}

impl HandOver<'_> {
    /// The script or manifest. Makes the folder of the logs, which Slurm expects.
    ///
    /// # Errors
    /// [`Error::Write`](cosmic::Error::Write) if that folder cannot be made.
    pub fn script(&self, scheduler: Scheduler) -> Result<String> {
        make_folder(&self.sweep.join("logs"))?;
        let tasks = &Tasks::of(self);
        Ok(match scheduler {
            Scheduler::Slurm => slurm::script(self, tasks),
            Scheduler::Parallel => parallel::script(self, tasks),
            Scheduler::Kubernetes => kubernetes::manifest(self, tasks),
        })
    }
}
