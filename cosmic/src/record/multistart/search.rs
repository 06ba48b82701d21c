//! The search over all starts, and its result.

use super::halving::{Halving, climb};
use super::starts::{folder_of, run_of, seeds, side_by_side};
use crate::codesign::{CoDesign, first_best};
use crate::error::{Error, Result};
use crate::record::design_file::DESIGN;
use crate::record::files::{copy_files, sweep, write_json};
use crate::record::history::{DESIGNS, LINES, TABLE};
use crate::record::run::{Lock, Observer, begin, keep_scene};
use crate::record::snapshot::{RunPlan, Search, Snapshot};
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
    let dropped = match plan.search {
        Search::Full => Halving::default(),
        Search::Halving => climb(folder, plan, observer)?,
    };
    let mut ended = finish_left(folder, plan, &dropped, observer)?.into_iter();
    let mut starts = Vec::new();
    let mut delivered: Vec<Summary> = Vec::new();
    let mut diverged = None;
    let mut seconds = 0.0;
    for seed in seeds(plan) {
        let dropped_at = dropped.dropped_at(seed);
        let is_left = dropped_at.is_none();
        let result = is_left.then(|| {
            ended
                .next()
                .expect("every start that was not dropped has a result")
        });
        let summary = result.transpose().unwrap_or_else(|error| {
            diverged.get_or_insert((seed, error));
            None
        });
        starts.push(Start::new(seed, summary.as_ref(), dropped_at));
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
    let best = delivered.swap_remove(first_best(delivered.iter().map(rank)));
    let files = [DESIGN, TRAJECTORY, LINES, TABLE, DESIGNS];
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

/// The numbers that a start is ranked by: the score, then the median to break ties.
fn rank(summary: &Summary) -> [f64; 2] {
    let numbers = [summary.score(), summary.displacement_selection_p50];
    numbers.map(|x| x.unwrap_or(f64::NEG_INFINITY))
}

/// Finishes the starts that were not dropped, and returns their results in the order of the seeds.
fn finish_left(
    folder: &Path,
    plan: &RunPlan,
    dropped: &Halving,
    observer: &mut dyn Observer,
) -> Result<Vec<Result<Summary>>> {
    let is_left = |seed: &u64| dropped.dropped_at(*seed).is_none();
    let left: Vec<u64> = seeds(plan).filter(is_left).collect();
    side_by_side(folder, &left, observer, |seed, observer| {
        let ended = match run_of(folder, seed, plan, usize::MAX)? {
            None => Summary::read(&folder_of(folder, seed)),
            Some(run) => run.finish(observer),
        };
        match ended {
            // A start that diverges does not stop the others.
            Err(error) if !error.is_of_rollouts() => Err(error),
            ended => Ok(ended),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::{create, rank, search};
    use crate::Registry;
    use crate::codesign::tests::tiny;
    use crate::codesign::{CoDesign, Reliability};
    use crate::record::multistart::starts::folder_of;
    use crate::record::snapshot::SNAPSHOT;
    use crate::record::{Observer, Run, RunPlan, optimise, resume};
    use rayon::ThreadPoolBuilder;
    use std::fs;
    use std::num::NonZeroUsize;
    use std::path::Path;

    fn plan() -> RunPlan {
        let mut scene = tiny();
        scene.schedule.iterations = 60;
        (scene.schedule.attraction_from, scene.schedule.snap_at) = (20, 40);
        RunPlan {
            starts: NonZeroUsize::new(3).unwrap(),
            ..RunPlan::new("test", scene, 3)
        }
    }

    /// The delivered designs of all starts and of the search.
    fn designs(folder: &Path) -> Vec<Vec<u8>> {
        let starts = (3..6).map(|seed| folder_of(folder, seed));
        let folders = starts.chain([folder.to_owned()]);
        folders
            .map(|f| fs::read(f.join("design.json")).unwrap())
            .collect()
    }

    /// An observer that stops every run during its delivery.
    struct StopsDelivery;

    impl Observer for StopsDelivery {
        fn is_stopped(&self) -> bool {
            true
        }
    }

    #[test]
    fn a_delivery_can_be_interrupted_and_resumed() {
        let folder = tempfile::tempdir().unwrap();
        for starts in [1, 3].map(|starts| NonZeroUsize::new(starts).unwrap()) {
            let plan = RunPlan { starts, ..plan() };
            let [whole, run] =
                ["whole", "run"].map(|name| folder.path().join(format!("{name}-{starts}")));
            optimise(&whole, &plan, &mut ()).unwrap();
            let stopped = optimise(&run, &plan, &mut StopsDelivery).unwrap_err();
            assert_eq!(stopped.exit_code(), 75, "{stopped}");
            assert!(!run.join("summary.json").exists());
            resume(&run, &Registry::default(), &mut ()).unwrap();
            for file in ["design.json", "trajectory.json"] {
                let [resumed, whole] =
                    [&run, &whole].map(|folder| fs::read(folder.join(file)).unwrap());
                assert!(resumed == whole, "{file} of {starts} starts");
            }
        }
    }

    /// The error names the start that failed, not the starts that were interrupted because of it.
    #[test]
    fn a_failed_start_is_named_and_the_others_are_saved() {
        let folder = tempfile::tempdir().unwrap();
        let [whole, run] = ["whole", "run"].map(|name| folder.path().join(name));
        optimise(&whole, &plan(), &mut ()).unwrap();
        let lock = create(&run, &plan()).unwrap();
        let stray = folder_of(&run, 4).join("stray");
        fs::create_dir_all(folder_of(&run, 4)).unwrap();
        fs::write(&stray, "").unwrap();
        let three = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let work = || search(lock, &plan(), &mut ());
        let says = three.install(work).unwrap_err().to_string();
        let place = Path::new("starts").join("4").display().to_string();
        assert!(
            says.contains(&format!("{place}: the folder is not empty")),
            "{says}"
        );
        fs::remove_file(stray).unwrap();
        three
            .install(|| resume(&run, &Registry::default(), &mut ()))
            .unwrap();
        assert_eq!(designs(&run), designs(&whole));
    }

    /// Another run in the folder of a start is neither resumed nor copied.
    #[test]
    fn another_run_in_the_folder_of_a_start_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let lock = create(folder.path(), &plan()).unwrap();
        let start = folder_of(folder.path(), 4);
        let mut other = RunPlan::new("test", plan().scene, 4);
        other.scene.physics.gravity = 1.0;
        let codesign = CoDesign::new(&other.scene).unwrap();
        let progress = codesign.begin(4).unwrap();
        drop(Run::begin(&start, &other, codesign, progress).unwrap());
        let before = fs::read(start.join(SNAPSHOT)).unwrap();
        let error = search(lock, &plan(), &mut ()).unwrap_err();
        let says = error.to_string();
        assert!(
            says.contains("holds another run") && error.exit_code() == 2,
            "{says}"
        );
        assert_eq!(fs::read(start.join(SNAPSHOT)).unwrap(), before);
    }

    /// An unreliable start is ranked by its 10 % quantile, and a start of an earlier version by its median.
    #[test]
    fn the_best_start_is_chosen_by_its_score() {
        let folder = tempfile::tempdir().unwrap();
        let summary = optimise(
            &folder.path().join("a"),
            &RunPlan::new("test", tiny(), 3),
            &mut (),
        );
        let mut summary = summary.unwrap();
        let score = summary.displacement_selection_score;
        assert_eq!(summary.reliability, Some(Reliability::Reliable));
        assert_eq!(score, summary.displacement_selection_p50);
        summary.displacement_selection_score = Some(-1.0);
        assert_eq!(rank(&summary), [-1.0, score.unwrap()]);
        summary.reliability = None;
        assert_eq!(rank(&summary), [score.unwrap(); 2]);
        summary.displacement_selection_p50 = None;
        assert_eq!(rank(&summary), [f64::NEG_INFINITY; 2]);
    }
}
