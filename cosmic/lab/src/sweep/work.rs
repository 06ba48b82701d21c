//! The work on a sweep: one run, the next run, or all that are left with a thread for each.

use super::claim::{Answer, Claim, PACE, claim};
use super::{HasScene, PLAN, RunState, SweepPlan};
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
use std::sync::Mutex;
use std::thread;
use std::time::Duration;

/// How often claims of other hosts are looked at.
const LOOK: Duration = Duration::from_secs(1);

/// The outcome of a run that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum RunOutcome {
    /// It ran to its end.
    Done(Box<Summary>),
    /// Its result diverges; the sentence says where.
    Diverged(String),
    /// It was already over.
    Over,
    /// Another process is at work on it.
    Taken,
}

/// A run that ended just now.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Its number.
    pub index: usize,
    /// Its outcome.
    pub outcome: RunOutcome,
}

/// Watches a sweep from another thread, and may end it early.
pub trait Overseer: Sync {
    /// True to stop the sweep. Runs save themselves first.
    fn is_stopped(&self) -> bool;

    /// Called when a run ended. Calls do not overlap.
    fn ended(&self, ended: &Ended);

    /// Passes on a [warning](Observer::warning) with the name of its run.
    fn warning(&self, run: &str, text: &str);
}

/// A sweep at work.
pub struct Sweep<'s, S> {
    /// The folder.
    pub folder: &'s Path,
    /// The plan.
    pub plan: &'s SweepPlan<S>,
    /// The items that the scenes may name.
    pub registry: &'s Registry,
}

impl<S: HasScene> Sweep<'_, S> {
    /// Begins or resumes one run. If a process on another host has claimed it, a minute tells whether that
    /// process still works; `is_stopped` may end the wait.
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

    /// Asks once a second until there is an answer.
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

    /// Begins or resumes one run; `None` if it is not known yet whether its holder, on another host, works.
    fn try_one(&self, index: usize, observer: &mut dyn Observer) -> Result<Option<RunOutcome>> {
        let folder = self.plan.folder(self.folder, index);
        if RunState::of(&folder).is_over() {
            return Ok(Some(RunOutcome::Over));
        }
        // A folder that is gone is not made anew.
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
        // The last holder of the claim may have finished the run.
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
                // Measured before the run is given back.
                if let Some(study) = &self.plan.study {
                    let is_stopped = || observer.is_stopped();
                    let measured = study.measure(&folder, self.registry, &is_stopped)?;
                    measured.ok_or_else(|| self.stopped())?;
                }
                RunOutcome::Done(Box::new(summary))
            }
            Err(error @ Error::Diverged { .. }) => RunOutcome::Diverged(error.to_string()),
            // Taken by `cosmic resume`, which makes no claims.
            Err(Error::Taken(_)) => RunOutcome::Taken,
            Err(error) => return Err(error),
        }))
    }

    /// Works on the first run that is neither over nor taken; `None` if there is none. It waits as
    /// [`run_one`](Self::run_one) does. A run that cannot be done, for its time step or because its files cannot
    /// be written, is passed over.
    ///
    /// # Errors
    /// The errors of [`run_one`](Self::run_one). A run that was passed over is reported only if no other
    /// is left.
    pub fn run_next(
        &self,
        observer: &mut dyn Observer,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<Ended>> {
        self.once_known(is_stopped, || self.try_next(observer))
    }

    /// As [`run_next`](Self::run_next), without waiting: `None` if it is not known yet whether anything is
    /// left, `Some(None)` if nothing is.
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

    /// Wraps the error of a single run, such as its time step or its files, so that it can be passed
    /// over. If the sweep's folder is gone, or the user interrupts, the work on the sweep ends.
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

    /// Works on every run that is neither over nor taken, see [`run_these`](Self::run_these).
    ///
    /// # Errors
    /// As there.
    pub fn run_all(&self, threads: Option<NonZeroUsize>, overseer: &dyn Overseer) -> Result<()> {
        let all: Vec<usize> = (0..self.plan.runs()).collect();
        self.run_these(&all, threads, overseer)
    }

    /// Works on those of some runs that are neither over nor taken, each on its own thread, until none
    /// is left. This includes runs that other processes give back meanwhile. A run that cannot be done is
    /// passed over, as by [`run_next`](Self::run_next).
    ///
    /// # Errors
    /// The first error of [`run_one`](Self::run_one); the error of a single run is reported after
    /// all others are done. [`Error::Stopped`] if the overseer asked for it.
    ///
    /// # Panics
    /// If the plan has no run of such a number.
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
            // Whether a holder on another host works is told by waiting.
            if unknown > 0 && taken + unknown == left.len() {
                thread::sleep(LOOK);
                continue;
            }
            // Nothing is left, or other processes are at work on all that is left.
            if taken + unknown == 0 || taken == left.len() {
                return first_of(passed_over);
            }
        }
    }

    /// Tries each run once: its outcome as of [`try_one`](Self::try_one), or the reason why it was passed over.
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
            // Count again: all threads have stopped now.
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

/// The error of the first run that was passed over, with the count of the others.
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

/// The observer of a run that is claimed.
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

    fn is_stopped(&self) -> bool {
        self.observer.is_stopped()
    }

    fn holds(&self) -> bool {
        !self.claim.is_lost()
    }
}

/// The observer of a run among others: it does not report iterations.
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

    fn is_stopped(&self) -> bool {
        self.overseer.is_stopped()
    }
}
