//! Writes scripts, or a manifest, that hand the unfinished runs of a sweep to a scheduler. Users can edit them.
//!
//! A task does one run, or several consecutive runs. Before the time of a task is up, the scheduler sends a signal. The
//! task then saves its runs and ends with exit code 75, and the scheduler queues it again.

mod task;
mod slurm;
mod parallel;
mod kubernetes;

use cosmic::error::{Error, Result};
use cosmic::record::files::make_folder;
use task::Tasks;

pub use task::HandOver;

/// A program that runs the tasks of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduler {
    /// Slurm, which runs an array of tasks.
    Slurm,
    /// GNU parallel, on one machine.
    Parallel,
    /// Kubernetes, which runs an indexed Job.
    Kubernetes,
}

impl HandOver<'_> {
    /// Returns the script or the manifest for a scheduler. Also creates the folder of the logs, which Slurm expects to
    /// exist.
    ///
    /// # Errors
    /// [`Error::Usage`] if the script cannot contain the name of the sweep's folder; [`Error::Write`] if the folder of
    /// the logs cannot be made.
    pub fn script(&self, scheduler: Scheduler) -> Result<String> {
        self.check_name(scheduler)?;
        make_folder(&self.sweep.join("logs"))?;
        let tasks = &Tasks::of(self);
        Ok(match scheduler {
            Scheduler::Slurm => slurm::script(self, tasks),
            Scheduler::Parallel => parallel::script(self, tasks),
            Scheduler::Kubernetes => kubernetes::manifest(self, tasks),
        })
    }

    /// Refuses the name of a sweep's folder if it is not UTF-8. For YAML, also refuses a name with line breaks or
    /// unprintable characters.
    fn check_name(&self, scheduler: Scheduler) -> Result<()> {
        let shown = self.sweep.display();
        let refuse = |says: &str| {
            Err(Error::Usage(format!(
                "the sweep's folder {shown:?} {says}; rename the folder"
            )))
        };
        let Some(name) = self.sweep.to_str() else {
            return refuse("has a name that is not UTF-8, which a script cannot contain");
        };
        let is_odd = |c: char| c.is_control() || "\u{2028}\u{2029}\u{feff}".contains(c);
        if scheduler == Scheduler::Kubernetes && name.contains(is_odd) {
            return refuse("has a control character in its name, which a manifest cannot contain");
        }
        Ok(())
    }
}
