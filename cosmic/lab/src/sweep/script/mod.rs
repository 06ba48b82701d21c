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
use task::Tasks;

pub use task::HandOver;

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
