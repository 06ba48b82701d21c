//! Doing the runs of a sweep: one, the next one, or all that are left, one a thread.

use super::claim::Claim;
use super::{RunState, SweepPlan};
use cosmic::codesign::Record;
use cosmic::error::{Error, Result};
use cosmic::parallel::{Crew, in_parallel};
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::{self, Observer, Run, Summary};
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Mutex;

/// What came of a run that was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It ran, or went on, to its end.
    Done(Box<Summary>),
    /// Its result flies apart: the sentence that says where.
    Diverged(String),
    /// It was over before.
    Over,
    /// Another process has it.
    Taken,
}

/// A run that ended just now.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Its number.
    pub index: usize,
    /// What came of it.
    pub outcome: Outcome,
}

/// Whoever watches a sweep from another thread, and may end it early.
pub trait Overseer: Sync {
    /// Whether to stop. Runs save themselves first.
    fn is_stopped(&self) -> bool;

    /// A run ended; calls do not overlap.
    fn ended(&self, ended: &Ended);

    /// What a run's observer is [warned](Observer::warning) of, and the run's name.
    fn warning(&self, run: &str, text: &str);
}

/// Does one run of a sweep, or goes on with it.
///
/// # Errors
/// Those of [`record::optimise`] and [`record::resume`], except a result's divergence.
///
/// # Panics
/// If the plan has no run of that number.
pub fn run_one(
    (sweep, plan): (&Path, &SweepPlan),
    index: usize,
    observer: &mut dyn Observer,
) -> Result<Outcome> {
    let folder = plan.folder(sweep, index);
    if RunState::of(&folder).is_over() {
        return Ok(Outcome::Over);
    }
    let Some(_claim) = Claim::take(sweep, &plan.name(index))? else {
        return Ok(Outcome::Taken);
    };
    // Whoever had the claim until just now may have finished.
    if RunState::of(&folder).is_over() {
        return Ok(Outcome::Over);
    }
    let done = match folder.join(SNAPSHOT).exists() {
        true => record::resume(&folder, observer),
        false => record::optimise(&folder, &plan.run(index), observer),
    };
    match done {
        Ok(summary) => Ok(Outcome::Done(Box::new(summary))),
        Err(error @ Error::Diverged { .. }) => Ok(Outcome::Diverged(error.to_string())),
        // By `cosmic resume`, which knows of no claims.
        Err(Error::Taken(_)) => Ok(Outcome::Taken),
        Err(error) => Err(error),
    }
}

/// Does the first run that is neither over nor taken; `None` where there is none. One that cannot
/// be done for a reason of its own, such as its time step, is passed over.
///
/// # Errors
/// As [`run_one`], of what is passed over where nothing else is left.
pub fn run_next(
    (sweep, plan): (&Path, &SweepPlan),
    observer: &mut dyn Observer,
) -> Result<Option<Ended>> {
    let mut passed_over = Vec::new();
    for index in 0..plan.runs() {
        match run_one((sweep, plan), index, observer) {
            Ok(Outcome::Over | Outcome::Taken) => {}
            Ok(outcome) => return Ok(Some(Ended { index, outcome })),
            Err(error) => passed_over.push(of_its_own((plan, index), error)?),
        }
    }
    first_of(passed_over).map(|()| None)
}

/// A run's error that says nothing of others, with the run: its time step, its files. Where nothing
/// can be written, or the user wants an end, that is the end of a sweep.
fn of_its_own((plan, index): (&SweepPlan, usize), error: Error) -> Result<Error> {
    match error {
        Error::Write { .. } | Error::Interrupted { .. } | Error::Stopped { .. } => Err(error),
        error => Ok(Error::PassedOver {
            run: format!("run {index}, {}", plan.name(index)),
            error: Box::new(error),
            others: 0,
        }),
    }
}

/// Says what was passed over, if anything was.
fn first_of(passed_over: Vec<Error>) -> Result<()> {
    let mut passed_over = passed_over.into_iter();
    let Some(mut first) = passed_over.next() else {
        return Ok(());
    };
    if let Error::PassedOver { others, .. } = &mut first {
        *others = passed_over.len();
    }
    Err(first)
}

/// Does every run that is neither over nor taken, each on a thread of its own; what cannot be done
/// for a reason of its own is passed over.
///
/// # Errors
/// As [`run_one`], the first of them, after all others are done if it is of one run alone;
/// [`Error::Stopped`] where the overseer asked for it.
pub fn run_all(
    (sweep, plan): (&Path, &SweepPlan),
    threads: Option<NonZeroUsize>,
    overseer: &dyn Overseer,
) -> Result<()> {
    let telling = Mutex::new(());
    let done = in_parallel(plan.runs(), Crew::of_one(threads), |index, _| {
        if overseer.is_stopped() {
            return Err(stopped(sweep, plan));
        }
        let name = plan.name(index);
        let mut quiet = Quiet {
            overseer,
            name: &name,
        };
        match run_one((sweep, plan), index, &mut quiet) {
            Ok(Outcome::Over | Outcome::Taken) => Ok(None),
            Ok(outcome) => {
                let _told = telling.lock();
                overseer.ended(&Ended { index, outcome });
                Ok(None)
            }
            Err(error) => of_its_own((plan, index), error).map(Some),
        }
    });
    match done {
        Ok(passed_over) => first_of(passed_over.into_iter().flatten().collect()),
        // Counted when all threads have stopped.
        Err(Error::Interrupted { .. } | Error::Stopped { .. }) => Err(stopped(sweep, plan)),
        Err(error) => Err(error),
    }
}

fn stopped(sweep: &Path, plan: &SweepPlan) -> Error {
    Error::Stopped {
        done: plan.over(sweep),
        total: plan.runs(),
    }
}

/// A run among others says nothing of its iterations.
struct Quiet<'o> {
    overseer: &'o dyn Overseer,
    name: &'o str,
}

impl Observer for Quiet<'_> {
    fn begin(&mut self, _: &Run) {}

    fn iteration(&mut self, _: &Run, _: &Record) -> ControlFlow<()> {
        match self.overseer.is_stopped() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn warning(&mut self, _: &Run, text: &str) {
        self.overseer.warning(self.name, text);
    }
}
