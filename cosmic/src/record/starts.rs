//! Several starts: every seed a run in `starts/SEED`, the best of them the result. All are carried
//! out whole, or those that [`halving`] leaves over.

use super::files::{sweep, write_atomic, write_json};
use super::folder::{Lock, begin, take_up};
use super::halving::{Halving, climb};
use super::history::{DESIGNS, LINES, TABLE};
use super::run::{DESIGN, DIVERGED, keep_scene};
use super::snapshot::{SNAPSHOT, Snapshot};
use super::summary::SUMMARY;
use super::trajectory_file::TRAJECTORY;
use super::{Observer, Plan, Run, Search, Start, Summary, resume, summary};
use crate::codesign::CoDesign;
use crate::error::{Error, Result};
use std::borrow::Cow;
use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// The most runs that go together, as starts or in a sweep: each is a folder.
pub(crate) const MOST_RUNS: usize = 1_000_000;

/// Begins the folder of several starts.
pub(super) fn create(folder: &Path, plan: &Plan) -> Result<Lock> {
    if plan.starts.get() > MOST_RUNS {
        let starts = plan.starts;
        return Err(Error::Usage(format!(
            "{starts} starts, where at most {MOST_RUNS} are allowed"
        )));
    }
    CoDesign::new(&plan.scene)?.begin(plan.seed)?;
    let more = plan.starts.get() as u64 - 1;
    if plan.seed.checked_add(more).is_none() {
        let (first, last) = (plan.seed, u64::MAX);
        return Err(Error::Usage(format!(
            "{more} more seeds than {first} would go beyond {last}"
        )));
    }
    let lock = begin(folder)?;
    let snapshot = Snapshot {
        plan: Cow::Borrowed(plan),
        seconds: 0.0,
        progress: None,
    };
    snapshot.write(folder)?;
    Ok(lock)
}

/// Does what is left of several starts, one after the other, and copies the best one's files.
pub(super) fn search(
    (folder, lock): (&Path, Lock),
    plan: &Plan,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    sweep(folder)?;
    keep_scene(folder, &plan.scene)?;
    let dropped = match plan.search {
        Search::Full => Halving::default(),
        Search::Halving => climb(folder, plan, observer)?,
    };
    let mut starts = Vec::new();
    let mut best: Option<Summary> = None;
    let mut diverged = None;
    let mut seconds = 0.0;
    for seed in seeds(plan) {
        if let Some(iteration) = dropped.dropped_at(seed) {
            seconds += Snapshot::read(&folder_of(folder, seed))?.seconds;
            starts.push(Start::dropped(seed, iteration));
            continue;
        }
        let summary = match one(folder, seed, plan, observer) {
            Ok(summary) => Some(summary),
            Err(error @ Error::Diverged { .. }) => {
                diverged.get_or_insert((seed, error));
                None
            }
            Err(error) => return Err(error),
        };
        starts.push(Start {
            seed,
            displacement_selection_p50: summary.as_ref().and_then(|s| s.displacement_selection_p50),
            displacement_p50: summary.as_ref().and_then(|s| s.displacement_p50),
            dropped_at: None,
        });
        seconds += match &summary {
            Some(summary) => summary.seconds,
            None => Snapshot::read(&folder_of(folder, seed))?.seconds,
        };
        best = better(best, summary);
    }
    let Some(best) = best else {
        let (seed, error) = diverged.expect("a start that was not delivered diverged");
        copy(&folder_of(folder, seed), folder, &[DIVERGED])?;
        return Err(error);
    };
    let files = [DESIGN, TRAJECTORY, LINES, TABLE, DESIGNS];
    copy(&folder_of(folder, best.seed), folder, &files)?;
    let summary = Summary {
        starts,
        seconds,
        ..best
    };
    write_json(&folder.join(SUMMARY), summary::FORMAT, &summary)?;
    lock.finish();
    Ok(summary)
}

/// The one with the higher median over the starts that choose; the first of equals. The figure
/// to quote is from other starts, or it would flatter the best of many.
fn better(best: Option<Summary>, other: Option<Summary>) -> Option<Summary> {
    let rank = |summary: &Option<Summary>| {
        let median = summary.as_ref()?.displacement_selection_p50;
        Some(median.unwrap_or(f64::NEG_INFINITY))
    };
    if rank(&other) > rank(&best) {
        other
    } else {
        best
    }
}

/// The seeds of a plan, in order.
pub(super) fn seeds(plan: &Plan) -> impl Iterator<Item = u64> + use<> {
    let first = plan.seed;
    (0..plan.starts.get() as u64).map(move |k| first.wrapping_add(k))
}

/// One seed's run: finished, gone on with, or begun.
fn one(folder: &Path, seed: u64, plan: &Plan, observer: &mut dyn Observer) -> Result<Summary> {
    let own = folder_of(folder, seed);
    let result = if own.join(SNAPSHOT).exists() {
        resume(&own, observer)
    } else {
        Run::create(&own, &alone(plan, seed)).and_then(|run| run.finish(observer))
    };
    result.map_err(|error| of_search(error, folder))
}

/// Takes one seed's run as far as an iteration, where it is not yet.
pub(super) fn pause(
    folder: &Path,
    (seed, iteration): (u64, usize),
    plan: &Plan,
    observer: &mut dyn Observer,
) -> Result<()> {
    let own = folder_of(folder, seed);
    let run = if own.join(SNAPSHOT).exists() {
        let Some((lock, snapshot)) = take_up(&own)? else {
            return Ok(());
        };
        let done = snapshot.progress.as_ref().map_or(0, |p| p.iteration);
        if done >= iteration {
            return Ok(());
        }
        Run::open(&own, lock, snapshot)
    } else {
        Run::create(&own, &alone(plan, seed))
    };
    run.and_then(|run| run.pause_at(iteration, observer))
        .map_err(|error| of_search(error, folder))
}

/// The plan of one of several starts.
fn alone(plan: &Plan, seed: u64) -> Plan {
    Plan {
        seed,
        starts: NonZeroUsize::MIN,
        search: Search::Full,
        ..plan.clone()
    }
}

/// It is the search that was interrupted, and that can be gone on with.
fn of_search(error: Error, folder: &Path) -> Error {
    match error {
        Error::Interrupted { iteration, .. } => Error::Interrupted {
            run: folder.into(),
            iteration,
        },
        error => error,
    }
}

pub(super) fn folder_of(folder: &Path, seed: u64) -> PathBuf {
    folder.join("starts").join(seed.to_string())
}

fn copy(from: &Path, to: &Path, names: &[&str]) -> Result<()> {
    names.iter().try_for_each(|name| {
        let path = from.join(name);
        let bytes = fs::read(&path).map_err(|source| Error::Read { path, source })?;
        write_atomic(&to.join(name), |file| file.write_all(&bytes))
    })
}
