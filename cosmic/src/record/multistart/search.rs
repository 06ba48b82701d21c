//! The search over all starts, and its result.

use super::starts::{folder_of, run_of, seeds, side_by_side};
use crate::codesign::{CoDesign, first_best};
use crate::error::{Error, Result};
use crate::record::design_file::DESIGN;
use crate::record::files::{copy_files, sweep, write_json};
use crate::record::history::{DESIGNS, LINES};
use crate::record::run::{Lock, Observer, begin, keep_scene, read_summary};
use crate::record::snapshot::{RunPlan, Snapshot};
use crate::record::summary::{self, DIVERGED, SUMMARY, Start, Summary};
use crate::record::trajectory_file::TRAJECTORY;
use std::path::Path;

/// The largest number of starts in a search, and of runs in a sweep. Each start and each run has its own folder.
pub const MOST_RUNS: usize = 1_000_000;

/// Begins a search in a new or empty folder.
pub(in crate::record) fn create(folder: &Path, plan: &RunPlan) -> Result<Lock> {
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
pub(in crate::record) fn search(
    lock: Lock,
    plan: &RunPlan,
    observer: &mut dyn Observer,
) -> Result<Summary> {
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

/// Finishes all starts, and returns their results in the order of the seeds.
fn finish(
    folder: &Path,
    plan: &RunPlan,
    observer: &mut dyn Observer,
) -> Result<Vec<Result<Summary>>> {
    side_by_side(folder, plan, observer, |seed, observer| {
        let ended = match run_of(folder, seed, plan)? {
            None => read_summary(&folder_of(folder, seed)),
            Some(run) => run.finish(observer),
        };
        match ended {
            // A start that diverges does not stop the others.
            Err(error) if !error.is_of_rollouts() => Err(error),
            ended => Ok(ended),
        }
    })
}
