//! Does the runs of a sweep: one run, or all unfinished runs on several threads.

use super::{Plan, SWEEP};
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::outcome::Summary;
use cosmic::parallel::{ThreadPlan, in_parallel};
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::{self, Observer, Run};
use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// The outcome of an attempt to do a run.
#[derive(Clone, Debug, PartialEq)]
pub enum RunOutcome {
    /// The run was done to its end.
    Done(Box<Summary>),
    /// The run ended, but its result diverges. The text is the error message.
    Diverged(String),
    /// The run was already finished.
    Over,
    /// Another process is doing the run.
    Taken,
}

/// Receives the events of a sweep, from any thread, and may stop the sweep early.
pub trait SweepObserver: Sync {
    /// The flag with which another thread asks the sweep to stop. The runs in progress are saved before they
    /// [stop](Observer::stop).
    fn stop(&self) -> Arc<AtomicBool>;

    /// Is called when the run with the number `index` has ended. Calls do not overlap.
    fn ended(&self, index: usize, outcome: &RunOutcome);

    /// Is called with a [warning](Observer::warning) of a run. `run` is the run's name.
    fn warning(&self, run: &str, text: &str);
}

/// A sweep: its folder, its plan, and the registry for its scenes.
pub struct Sweep<'s> {
    /// The folder of the sweep, in which the plan is [kept](Plan::keep).
    pub folder: &'s Path,
    /// The plan of the sweep.
    pub plan: &'s Plan,
    /// The laws and losses that the scenes may name.
    pub registry: &'s Registry,
}

impl Sweep<'_> {
    /// Begins or resumes the run with this number.
    ///
    /// # Errors
    /// The errors of [`record::optimise`] and [`record::resume_of`], except the divergence of a result and a run that
    /// another process does; [`Error::Usage`] if the sweep has no run of that number.
    pub fn run_one(&self, index: usize, observer: &mut dyn Observer) -> Result<RunOutcome> {
        let plan = self.plan.run(index, self.registry)?;
        if self.plan.is_over(self.folder, index) {
            return Ok(RunOutcome::Over);
        }
        // If the sweep's folder has been removed, do not create it again.
        let file = self.folder.join(SWEEP);
        fs::metadata(&file).map_err(Error::writing(&file))?;
        let folder = self.plan.folder(self.folder, index);
        let has_begun = || folder.join(SNAPSHOT).exists();
        let done = match has_begun() {
            false => record::optimise(&folder, &plan, observer).map(Some),
            true => record::resume_of(&folder, &plan, observer),
        };
        let done = match done {
            // Another process began the run in the meantime.
            Err(Error::Usage(_)) if has_begun() => record::resume_of(&folder, &plan, observer),
            done => done,
        };
        match done {
            Ok(Some(summary)) => Ok(RunOutcome::Done(Box::new(summary))),
            // Another process has finished the run in the meantime.
            Ok(None) => Ok(RunOutcome::Over),
            Err(error @ Error::Diverged { .. }) => Ok(RunOutcome::Diverged(error.to_string())),
            Err(Error::Taken(_)) => Ok(RunOutcome::Taken),
            Err(error) => Err(error),
        }
    }

    /// Does all unfinished runs in parallel, except those that other processes are doing. If another process stops
    /// before its run is finished, this process does the run. If a run fails, the others are still done.
    ///
    /// # Errors
    /// The first error of [`run_one`](Self::run_one). An error that concerns only one run is returned after all other
    /// runs are done. [`Error::Stopped`] if the observer stops the sweep.
    pub fn run_all(
        &self,
        threads: Option<NonZeroUsize>,
        observer: &dyn SweepObserver,
    ) -> Result<()> {
        let mut failed = BTreeMap::new();
        loop {
            let left = self.plan.left(self.folder);
            let left: Vec<usize> = left.filter(|index| !failed.contains_key(index)).collect();
            let mut any_done = false;
            for (index, tried) in left.iter().zip(self.try_each(&left, threads, observer)?) {
                match tried {
                    Ok(outcome) => any_done |= matches!(outcome, RunOutcome::Done(_)),
                    Err(error) => _ = failed.insert(*index, error),
                }
            }
            // Meanwhile, another process may have stopped before its run was finished. Such runs are tried again.
            if !any_done {
                return first_of(failed);
            }
        }
    }

    /// Tries each run once. Returns, for each run, its outcome or its error.
    fn try_each(
        &self,
        runs: &[usize],
        threads: Option<NonZeroUsize>,
        observer: &dyn SweepObserver,
    ) -> Result<Vec<Result<RunOutcome>>> {
        let telling = Mutex::new(());
        let done = in_parallel(runs.len(), ThreadPlan::of_one(threads), |k, _| {
            if observer.stop().load(Ordering::Relaxed) {
                return Err(self.stopped());
            }
            let index = runs[k];
            let name = &self.plan.name(index);
            let outcome = match self.run_one(index, &mut RunObserver { observer, name }) {
                // A process of another host probably does the run.
                Err(Error::Claimed { .. }) => RunOutcome::Taken,
                Err(error) => return self.of_one_run(index, error).map(Err),
                Ok(outcome) => outcome,
            };
            if matches!(outcome, RunOutcome::Done(_) | RunOutcome::Diverged(_)) {
                let _told = telling.lock();
                observer.ended(index, &outcome);
            }
            Ok(Ok(outcome))
        });
        match done {
            // Count the finished runs only now, when all threads have stopped.
            Err(Error::Interrupted { .. } | Error::Stopped { .. }) => Err(self.stopped()),
            done => done,
        }
    }

    /// Decides whether the sweep goes on after the error of a run. Returns `Ok` with the error if only this run failed,
    /// for example because of its time step or its files. Returns `Err` if all work must end, because the sweep's
    /// folder is gone or the user interrupts.
    fn of_one_run(&self, index: usize, error: Error) -> Result<Error> {
        match error {
            Error::Interrupted { .. } => Err(error),
            error if !self.folder.join(SWEEP).exists() => Err(error),
            error => Ok(Error::PassedOver {
                run: format!("run {index}, {}", self.plan.name(index)),
                error: Box::new(error),
                others: 0,
            }),
        }
    }

    fn stopped(&self) -> Error {
        let total = self.plan.runs();
        Error::Stopped {
            done: total - self.plan.left(self.folder).count(),
            total,
        }
    }
}

/// Returns the error of the first failed run. The error also states how many other runs failed.
fn first_of(failed: BTreeMap<usize, Error>) -> Result<()> {
    let count = failed.len();
    let Some(mut first) = failed.into_values().next() else {
        return Ok(());
    };
    if let Error::PassedOver { others, .. } = &mut first {
        *others = count - 1;
    }
    Err(first)
}

/// The observer of one of several parallel runs. It passes warnings on to the observer of the sweep.
struct RunObserver<'o> {
    observer: &'o dyn SweepObserver,
    name: &'o str,
}

impl Observer for RunObserver<'_> {
    fn warning(&mut self, _: &Run, text: &str) {
        self.observer.warning(self.name, text);
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(self.observer.stop())
    }
}
