//! Does the runs of a sweep: one run, the next run, or all unfinished runs on several threads.

use super::claim::{Answer, Claim, PACE, claim};
use super::{PLAN, RunState, SweepPlan};
use cosmic::Registry;
use cosmic::codesign::Record;
use cosmic::error::{Error, Result};
use cosmic::parallel::{Crew, in_parallel};
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::{self, Observer, Run, Summary};
use std::collections::BTreeMap;
use std::fs;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// The time to wait before the claims of other hosts are checked again.
const LOOK: Duration = Duration::from_secs(1);

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

/// A run of the sweep that has just ended.
#[derive(Clone, Debug)]
pub struct Ended {
    /// The run's number in the plan.
    pub index: usize,
    /// The run's outcome.
    pub outcome: RunOutcome,
}

/// Receives the events of a sweep, from any thread, and may stop the sweep early.
pub trait Overseer: Sync {
    /// Returns true if the sweep must stop. The runs in progress are saved before they stop.
    fn is_stopped(&self) -> bool;

    /// The flag with which another thread asks the runs to [stop](Observer::stop).
    fn stop(&self) -> Option<Arc<AtomicBool>> {
        None
    }

    /// Is called when a run has ended. Calls do not overlap.
    fn ended(&self, ended: &Ended);

    /// Is called with a [warning](Observer::warning) of a run. `run` is the run's name.
    fn warning(&self, run: &str, text: &str);
}

/// A sweep: its folder, its plan, and the registry for its scenes.
pub struct Sweep<'s> {
    /// The folder of the sweep.
    pub folder: &'s Path,
    /// The plan of the sweep.
    pub plan: &'s SweepPlan,
    /// The laws and losses that the scenes may name.
    pub registry: &'s Registry,
}

impl Sweep<'_> {
    /// Begins or resumes one run. If a process on another host has claimed the run, this function first waits up to a
    /// minute to find out whether that process still works. The observer's `is_stopped` may end the wait.
    ///
    /// # Errors
    /// The errors of [`record::optimise`] and [`record::resume_of`], except the divergence of a result; the errors
    /// of measuring; [`Error::Stopped`].
    ///
    /// # Panics
    /// If the plan has no run of that number.
    pub fn run_one(
        &self,
        index: usize,
        observer: &mut dyn Observer,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<RunOutcome> {
        self.once_known(is_stopped, || self.try_one(index, observer))
    }

    /// Calls `ask` once a second until the answer is not `None`.
    fn once_known<T>(
        &self,
        is_stopped: &dyn Fn() -> bool,
        mut ask: impl FnMut() -> Result<Option<T>>,
    ) -> Result<T> {
        loop {
            if let Some(answer) = ask()? {
                return Ok(answer);
            }
            if is_stopped() {
                return Err(self.stopped());
            }
            thread::sleep(LOOK);
        }
    }

    /// Begins or resumes one run. Returns `None` if a process on another host holds the claim, and it is not known yet
    /// whether that process still works.
    fn try_one(&self, index: usize, observer: &mut dyn Observer) -> Result<Option<RunOutcome>> {
        let folder = self.plan.folder(self.folder, index);
        if RunState::of(&folder).is_over() {
            return Ok(Some(RunOutcome::Over));
        }
        // If the sweep's folder has been removed, do not create it again.
        let plan = self.folder.join(PLAN);
        fs::metadata(&plan).map_err(Error::writing(&plan))?;
        let claim = match claim(self.folder, &self.plan.name(index), PACE)? {
            Answer::Granted(claim) => claim,
            Answer::Taken => return Ok(Some(RunOutcome::Taken)),
            Answer::Watched => return Ok(None),
        };
        let observer = &mut Holding {
            claim: &claim,
            observer,
        };
        // The process that held the claim before may have finished the run in the meantime.
        if RunState::of(&folder).is_over() {
            return Ok(Some(RunOutcome::Over));
        }
        let plan = self.plan.run(index, self.registry)?;
        let done = if folder.join(SNAPSHOT).exists() {
            record::resume_of(&folder, &plan, observer)
        } else {
            record::optimise(&folder, &plan, observer)
        };
        Ok(Some(match done {
            Ok(summary) => {
                // The run must be measured while this process still holds the claim.
                if let Some(study) = &self.plan.study {
                    let is_stopped = || observer.is_stopped();
                    let measured = study.measure(&folder, self.registry, &is_stopped)?;
                    measured.ok_or_else(|| self.stopped())?;
                }
                RunOutcome::Done(Box::new(summary))
            }
            Err(error @ Error::Diverged { .. }) => RunOutcome::Diverged(error.to_string()),
            // `cosmic resume`, which does not claim runs, is doing the run.
            Err(Error::Taken(_)) => RunOutcome::Taken,
            Err(error) => return Err(error),
        }))
    }

    /// Does the first run that is neither finished nor claimed by another process. Returns `None` if there is no such
    /// run. Waits like [`run_one`](Self::run_one). If a run fails, for example because of its time step or its files,
    /// the next one is tried.
    ///
    /// # Errors
    /// The errors of [`run_one`](Self::run_one). The error of a failed run is returned only if no other run remains.
    pub fn run_next(
        &self,
        observer: &mut dyn Observer,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<Ended>> {
        self.once_known(is_stopped, || self.try_next(observer))
    }

    /// Like [`run_next`](Self::run_next), but does not wait. Returns `None` if it is not known yet whether any run
    /// remains, and `Some(None)` if no run remains.
    fn try_next(&self, observer: &mut dyn Observer) -> Result<Option<Option<Ended>>> {
        let mut passed_over = BTreeMap::new();
        let mut is_known = true;
        for index in 0..self.plan.runs() {
            match self.try_one(index, observer) {
                Ok(Some(RunOutcome::Over | RunOutcome::Taken)) => {}
                Ok(Some(outcome)) => return Ok(Some(Some(Ended { index, outcome }))),
                Ok(None) => is_known = false,
                Err(error) => {
                    passed_over.insert(index, self.of_one_run(index, error)?);
                }
            }
        }
        if !is_known {
            return Ok(None);
        }
        first_of(passed_over).map(|()| Some(None))
    }

    /// Decides whether the sweep goes on after the error of a run. Returns `Ok` with the error if only this run failed,
    /// for example because of its time step or its files. Returns `Err` if all work must end, because the sweep's
    /// folder is gone or the user interrupts.
    fn of_one_run(&self, index: usize, error: Error) -> Result<Error> {
        match error {
            Error::Interrupted { .. } | Error::Stopped { .. } => Err(error),
            error if !self.folder.join(PLAN).exists() => Err(error),
            error => Ok(Error::PassedOver {
                run: format!("run {index}, {}", self.plan.name(index)),
                error: Box::new(error),
                others: 0,
            }),
        }
    }

    /// Does every run that is neither finished nor claimed by another process; see [`run_these`](Self::run_these).
    ///
    /// # Errors
    /// The errors of [`run_these`](Self::run_these).
    pub fn run_all(&self, threads: Option<NonZeroUsize>, overseer: &dyn Overseer) -> Result<()> {
        let all: Vec<usize> = (0..self.plan.runs()).collect();
        self.run_these(&all, threads, overseer)
    }

    /// Does the runs with the given numbers in parallel, until each is finished or claimed by another process. If
    /// another process gives a run back in the meantime, that run is done too. If a run fails, the others are still
    /// done.
    ///
    /// # Errors
    /// The first error of [`run_one`](Self::run_one). An error that concerns only one run is returned after all other
    /// runs are done. [`Error::Stopped`] if the overseer stops the sweep.
    ///
    /// # Panics
    /// If the plan has no run with one of these numbers.
    pub fn run_these(
        &self,
        runs: &[usize],
        threads: Option<NonZeroUsize>,
        overseer: &dyn Overseer,
    ) -> Result<()> {
        let mut passed_over = BTreeMap::new();
        loop {
            let is_over = |k: &usize| RunState::of(&self.plan.folder(self.folder, *k)).is_over();
            let runs = runs.iter().copied();
            let left: Vec<usize> = runs
                .filter(|index| !passed_over.contains_key(index) && !is_over(index))
                .collect();
            let (mut taken, mut unknown) = (0, 0);
            for (index, tried) in left.iter().zip(self.try_each(&left, threads, overseer)?) {
                match tried {
                    Ok(outcome) => {
                        taken += usize::from(outcome == Some(RunOutcome::Taken));
                        unknown += usize::from(outcome.is_none());
                    }
                    Err(error) => _ = passed_over.insert(*index, error),
                }
            }
            // Nothing else is left to do: wait, to find out whether the holders on other hosts still work.
            if unknown > 0 && taken + unknown == left.len() {
                thread::sleep(LOOK);
                continue;
            }
            // Each of the runs is finished, or another process is doing it.
            if taken + unknown == 0 || taken == left.len() {
                return first_of(passed_over);
            }
        }
    }

    /// Tries each run once. Returns, for each run, the result of [`try_one`](Self::try_one), or the error of the run.
    fn try_each(
        &self,
        runs: &[usize],
        threads: Option<NonZeroUsize>,
        overseer: &dyn Overseer,
    ) -> Result<Vec<Result<Option<RunOutcome>>>> {
        let telling = Mutex::new(());
        let done = in_parallel(runs.len(), Crew::of_one(threads), |k, _| {
            if overseer.is_stopped() {
                return Err(self.stopped());
            }
            let index = runs[k];
            let name = &self.plan.name(index);
            match self.try_one(index, &mut Quiet { overseer, name }) {
                Err(error) => self.of_one_run(index, error).map(Err),
                Ok(Some(outcome @ (RunOutcome::Done(_) | RunOutcome::Diverged(_)))) => {
                    let _told = telling.lock();
                    overseer.ended(&Ended { index, outcome });
                    Ok(Ok(Some(RunOutcome::Over)))
                }
                tried => Ok(tried),
            }
        });
        match done {
            // Count the finished runs only now, when all threads have stopped.
            Err(Error::Interrupted { .. } | Error::Stopped { .. }) => Err(self.stopped()),
            done => done,
        }
    }

    fn stopped(&self) -> Error {
        Error::Stopped {
            done: self.plan.over(self.folder),
            total: self.plan.runs(),
        }
    }
}

/// Returns the error of the first failed run. The error also states how many other runs failed.
fn first_of(passed_over: BTreeMap<usize, Error>) -> Result<()> {
    let count = passed_over.len();
    let Some(mut first) = passed_over.into_values().next() else {
        return Ok(());
    };
    if let Error::PassedOver { others, .. } = &mut first {
        *others = count - 1;
    }
    Err(first)
}

/// The observer of a run that this process has claimed. It passes events on, and tells the run whether this process
/// still holds the claim.
struct Holding<'c> {
    claim: &'c Claim,
    observer: &'c mut dyn Observer,
}

impl Observer for Holding<'_> {
    fn begin(&mut self, run: &Run) {
        self.observer.begin(run);
    }

    fn iteration(&mut self, run: &Run, record: &Record) -> ControlFlow<()> {
        self.observer.iteration(run, record)
    }

    fn end(&mut self, run: &Run) {
        self.observer.end(run);
    }

    fn warning(&mut self, run: &Run, text: &str) {
        self.observer.warning(run, text);
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        self.observer.stop()
    }

    fn is_stopped(&self) -> bool {
        self.observer.is_stopped()
    }

    fn holds(&self) -> bool {
        !self.claim.is_lost()
    }
}

/// The observer of one of several parallel runs. It passes warnings on to the overseer and ignores iterations.
struct Quiet<'o> {
    overseer: &'o dyn Overseer,
    name: &'o str,
}

impl Observer for Quiet<'_> {
    fn begin(&mut self, _: &Run) {}

    fn iteration(&mut self, _: &Run, _: &Record) -> ControlFlow<()> {
        if self.overseer.is_stopped() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }

    fn warning(&mut self, _: &Run, text: &str) {
        self.overseer.warning(self.name, text);
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        self.overseer.stop()
    }

    fn is_stopped(&self) -> bool {
        self.overseer.is_stopped()
    }
}
