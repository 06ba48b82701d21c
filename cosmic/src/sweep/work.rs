//! Doing the runs of a sweep: one, the next one, or all that are left, one a thread.

use super::claim::Claim;
use super::{RunState, SweepPlan};
use crate::codesign::Record;
use crate::error::{Error, Result};
use crate::parallel::{Crew, in_parallel};
use crate::record::snapshot::SNAPSHOT;
use crate::record::{self, Observer, Run, Summary};
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
        Err(error) => Err(error),
    }
}

/// Does the first run that is neither over nor taken; `None` where there is none.
///
/// # Errors
/// As [`run_one`].
pub fn run_next(
    (sweep, plan): (&Path, &SweepPlan),
    observer: &mut dyn Observer,
) -> Result<Option<Ended>> {
    for index in 0..plan.runs() {
        let outcome = run_one((sweep, plan), index, observer)?;
        if !matches!(outcome, Outcome::Over | Outcome::Taken) {
            return Ok(Some(Ended { index, outcome }));
        }
    }
    Ok(None)
}

/// Does every run that is neither over nor taken, each on a thread of its own.
///
/// # Errors
/// As [`run_one`], the first of them; [`Error::Stopped`] where the overseer asked for it.
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
        let outcome = run_one((sweep, plan), index, &mut Quiet(overseer))?;
        if !matches!(outcome, Outcome::Over | Outcome::Taken) {
            let _told = telling.lock();
            overseer.ended(&Ended { index, outcome });
        }
        Ok(())
    });
    done.map(drop).map_err(|error| match error {
        // Counted when all threads have stopped.
        Error::Interrupted { .. } | Error::Stopped { .. } => stopped(sweep, plan),
        error => error,
    })
}

fn stopped(sweep: &Path, plan: &SweepPlan) -> Error {
    let is_over = |index: &usize| RunState::of(&plan.folder(sweep, *index)).is_over();
    Error::Stopped {
        done: (0..plan.runs()).filter(is_over).count(),
        total: plan.runs(),
    }
}

/// A run among others says nothing of its iterations.
struct Quiet<'o>(&'o dyn Overseer);

impl Observer for Quiet<'_> {
    fn begin(&mut self, _: &Run) {}

    fn iteration(&mut self, _: &Run, _: &Record) -> ControlFlow<()> {
        match self.0.is_stopped() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}
