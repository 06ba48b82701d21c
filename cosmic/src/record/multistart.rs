//! Multi-start search: every seed is a run in `starts/SEED`, and the best run is the result.

use super::files::{DESIGN, copy_files, sweep, write_json};
use super::history::{DESIGNS, LINES};
use super::run::{Lock, Observer, Run, begin, keep_scene, read_summary, take_up};
use super::snapshot::{RunPlan, SNAPSHOT, Snapshot};
use super::summary::{self, DIVERGED, SUMMARY};
use super::trajectory_file::TRAJECTORY;
use crate::error::{Error, Result};
use crate::judge::first_best;
use crate::outcome::{Start, Summary};
use crate::parallel::{ThreadPlan, in_parallel};
use crate::search::{CoDesign, Record};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The largest number of starts in a search, and of runs in a sweep. Each start and each run has its own folder.
pub const MOST_RUNS: usize = 1_000_000;

/// Begins a search in a new or empty folder.
pub(super) fn create(folder: &Path, plan: &RunPlan) -> Result<Lock> {
    refuse_many(plan)?;
    CoDesign::new(&plan.scene)?.begin(plan.seed)?;
    let more = plan.starts.get() as u64 - 1;
    if plan.seed.checked_add(more).is_none() {
        let (first, last) = (plan.seed, u64::MAX);
        return Err(Error::Usage(format!(
            "the seed is {first}, but the seeds of {more} more starts would exceed the largest seed, {last}; begin \
            with a lower seed"
        )));
    }
    let lock = begin(folder)?;
    Snapshot::save(folder, plan, 0.0, None)?;
    Ok(lock)
}

fn refuse_many(plan: &RunPlan) -> Result<()> {
    let starts = plan.starts;
    if starts.get() > MOST_RUNS {
        return Err(Error::Usage(format!(
            "the number of starts is {starts}; expected at most {MOST_RUNS}"
        )));
    }
    Ok(())
}

/// Finishes all starts, and copies the result files of the best start to the folder of the search.
pub(super) fn search(lock: Lock, plan: &RunPlan, observer: &mut dyn Observer) -> Result<Summary> {
    let folder = lock.folder();
    refuse_many(plan)?;
    sweep(folder)?;
    keep_scene(folder, &plan.scene)?;
    let ended = finish(folder, plan, observer)?;
    let mut starts = Vec::new();
    let mut delivered: Vec<Summary> = Vec::new();
    let mut diverged = None;
    let mut seconds = 0.0;
    for (seed, ended) in seeds(plan).zip(ended) {
        let summary = match ended {
            Ok(summary) => Some(summary),
            Err(error) => {
                diverged.get_or_insert((seed, error));
                None
            }
        };
        starts.push(Start::new(seed, summary.as_ref()));
        seconds += match &summary {
            Some(summary) => summary.seconds,
            None => Snapshot::read(&folder_of(folder, seed), plan.scene.registry())?.seconds,
        };
        delivered.extend(summary);
    }
    if delivered.is_empty() {
        let (seed, error) = diverged.expect("a start that was not delivered has an error");
        let start = folder_of(folder, seed);
        if start.join(DIVERGED).exists() {
            copy_files(&start, folder, &[DIVERGED])?;
        }
        return Err(error);
    }
    // If several starts have equal ranks, the first wins. The score of the best start is not the figure to quote: as
    // the highest of many scores, it is too optimistic. The figure to quote comes from other perturbed starts.
    let best = delivered.swap_remove(first_best(delivered.iter().map(Summary::rank)));
    let files = [DESIGN, TRAJECTORY, LINES, DESIGNS];
    copy_files(&folder_of(folder, best.seed), folder, &files)?;
    let summary = Summary {
        starts,
        seconds,
        ..best
    };
    write_json(&folder.join(SUMMARY), summary::FORMAT, &summary)?;
    lock.finish();
    Ok(summary)
}

/// Finishes all starts in parallel, one per thread, and returns their results in the order of the seeds. A start that
/// diverges does not stop the others. If one start fails or is interrupted, the others are interrupted. An error that
/// tells the user to resume names the folder of the search, not the folder of a start.
fn finish(
    folder: &Path,
    plan: &RunPlan,
    observer: &mut dyn Observer,
) -> Result<Vec<Result<Summary>>> {
    let seeds: Vec<u64> = seeds(plan).collect();
    let threads = ThreadPlan::shared_out(rayon::current_num_threads(), seeds.len());
    let observer = &Mutex::new(observer);
    in_parallel(seeds.len(), threads, |k, failed| {
        match finish_start(
            folder,
            plan,
            seeds[k],
            &mut StartObserver { observer, failed },
        ) {
            Err(mut error) if !error.is_of_rollouts() => {
                if let Error::Interrupted { run, .. } | Error::UnstableRun { run, .. } = &mut error
                {
                    *run = folder.into();
                }
                Err(error)
            }
            ended => Ok(ended),
        }
    })
}

/// Begins or continues the run of one seed, and finishes it.
fn finish_start(
    folder: &Path,
    plan: &RunPlan,
    seed: u64,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    let own = folder_of(folder, seed);
    let of_one = RunPlan {
        iterations: plan.iterations,
        ..RunPlan::new(&plan.name, plan.scene.clone(), seed)
    };
    if !own.join(SNAPSHOT).exists() {
        return Run::create(&own, &of_one)?.finish(observer);
    }
    let Some((lock, snapshot)) = take_up(&own, plan.scene.registry())? else {
        return read_summary(&own);
    };
    snapshot.plan.check_same(&of_one, &own)?;
    Run::open(lock, snapshot, None)?.finish(observer)
}

/// The observer of one start. It passes all events to the common observer.
struct StartObserver<'a, 'o> {
    observer: &'a Mutex<&'o mut dyn Observer>,
    /// True after one of the starts has failed.
    failed: &'a AtomicBool,
}

impl<'o> StartObserver<'_, 'o> {
    fn observer(&self) -> MutexGuard<'_, &'o mut dyn Observer> {
        self.observer.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for StartObserver<'_, '_> {
    fn begin(&mut self, run: &Run) {
        self.observer().begin(run);
    }

    fn iteration(&mut self, run: &Run, record: &Record) -> ControlFlow<()> {
        if self.failed.load(Ordering::Acquire) {
            return ControlFlow::Break(());
        }
        self.observer().iteration(run, record)
    }

    fn end(&mut self, run: &Run) {
        self.observer().end(run);
    }

    fn warning(&mut self, run: &Run, text: &str) {
        let seed = run.plan().seed;
        (self.observer()).warning(run, &format!("seed {seed}: {text}"));
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        self.observer().stop()
    }

    fn is_stopped(&self) -> bool {
        self.failed.load(Ordering::Acquire) || self.observer().is_stopped()
    }
}

/// The seeds of a plan, in order.
fn seeds(plan: &RunPlan) -> impl Iterator<Item = u64> + use<> {
    let first = plan.seed;
    (0..plan.starts.get() as u64).map(move |k| first.wrapping_add(k))
}

/// The folders of the starts that have begun.
pub(super) fn begun(folder: &Path, plan: &RunPlan) -> Vec<PathBuf> {
    let folders = seeds(plan).map(|seed| folder_of(folder, seed));
    folders.filter(|own| own.join(SNAPSHOT).exists()).collect()
}

/// The folder of the start with this seed, in the folder of a search.
pub fn folder_of(folder: &Path, seed: u64) -> PathBuf {
    folder.join("starts").join(seed.to_string())
}
