//! The functions that begin, continue and deliver runs in folders.

use super::files::copy_files;
use super::history::{DESIGNS, LINES, TABLE};
use super::multistart;
use super::run::{Lock, Observer, Run, SCENE, begin, keep_scene, take_up};
use super::snapshot::{RunPlan, SNAPSHOT, Snapshot};
use super::summary::{SUMMARY, Summary};
use crate::codesign::{CoDesign, Progress};
use crate::error::{Error, Result};
use crate::registry::Registry;
use crate::scene::UnstableStep;
use std::fs;
use std::io::ErrorKind;
use std::num::NonZeroUsize;
use std::path::Path;

/// Carries out a plan in a new or empty folder.
///
/// # Errors
/// - [`Error::Usage`] for a folder that is not empty, and for a plan that cannot be carried out;
/// - [`Error::Taken`] for a folder that another process uses;
/// - the errors of [`Scene::check`](crate::scene::Scene::check);
/// - [`Error::UnstableStep`] if the time step is unstable for the start, and [`Error::UnstableRun`] if it becomes
///   unstable later, unless the scene allows that;
/// - [`Error::Write`];
/// - [`Error::Interrupted`] if the observer interrupted the run;
/// - [`Error::Diverged`] if the delivered design diverges. Its last states are in the folder.
pub fn optimise(folder: &Path, plan: &RunPlan, observer: &mut dyn Observer) -> Result<Summary> {
    if plan.starts.get() == 1 {
        return Run::create(folder, plan)?.finish(observer);
    }
    let lock = multistart::create(folder, plan)?;
    multistart::search(lock, plan, observer)
}

/// Carries out a plan of one start with the caller's `codesign` and `progress`. This allows the caller's own
/// [loss](CoDesign::with_loss), and a [given robot](CoDesign::begin_with), which is saved as `start.json`.
///
/// # Errors
/// Like [`optimise`]; [`Error::Usage`] if the optimisation has another scene or seed than the plan.
pub fn optimise_with(
    folder: &Path,
    plan: &RunPlan,
    codesign: CoDesign,
    progress: Progress,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    if plan.starts.get() > 1 {
        return Err(Error::Usage(
            "an optimisation with the caller's robot or loss must have one start, but the plan has several; plan \
            one run per seed".into(),
        ));
    }
    let first = codesign.first(plan.seed)?;
    let is_of_plan = (codesign.scene(), progress.seed) == (&plan.scene, plan.seed);
    if !is_of_plan || progress.own_loss != first.own_loss {
        return Err(Error::Usage(
            "the scene, the seed and the loss of the optimisation and of its progress must be those of the plan".into(),
        ));
    }
    progress.fits(&first, "the initial progress")?;
    if progress.iteration != progress.before_first() {
        return Err(Error::Usage(format!(
            "the initial progress must be at iteration 0, but {} iterations are done; to continue a run, use `resume_with`",
            progress.iteration - progress.before_first()
        )));
    }
    Run::begin(folder, plan, codesign, progress)?.finish(observer)
}

/// Continues the run in a folder and returns its summary. If the run is finished, only reads the summary.
///
/// # Errors
/// [`Error::Read`] if there is no run, [`Error::Malformed`] or [`Error::Misfit`] for a damaged snapshot, otherwise
/// like [`optimise`].
pub fn resume(folder: &Path, registry: &Registry, observer: &mut dyn Observer) -> Result<Summary> {
    resume_if(folder, registry, |_| Ok(()), None, observer)
}

/// Like [`resume`], for a run that began with the caller's loss. `codesign` must have that loss.
///
/// # Errors
/// Like [`resume`]; [`Error::Usage`] if `codesign` has another scene than the run, or if the folder holds several
/// starts.
pub fn resume_with(
    folder: &Path,
    codesign: CoDesign,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    let registry = codesign.scene().registry().clone();
    resume_if(folder, &registry, |_| Ok(()), Some(codesign), observer)
}

/// Like [`resume`], but only if the run in the folder has the plan `plan`.
///
/// # Errors
/// Like [`resume`]; [`Error::Usage`] if the folder holds an unfinished run of another plan, which is left unchanged.
pub fn resume_of(folder: &Path, plan: &RunPlan, observer: &mut dyn Observer) -> Result<Summary> {
    let accept = |found: &RunPlan| found.check_same(plan, folder);
    resume_if(folder, plan.scene.registry(), accept, None, observer)
}

/// Continues the run in a folder if `accept` accepts its plan. If `own` is given, this optimisation of the caller is
/// used.
fn resume_if(
    folder: &Path,
    registry: &Registry,
    accept: impl FnOnce(&RunPlan) -> Result<()>,
    own: Option<CoDesign>,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    let Some((lock, snapshot)) = take_up(folder, registry)? else {
        return Summary::read(folder);
    };
    accept(&snapshot.plan)?;
    if snapshot.progress.is_some() {
        return Run::open(lock, snapshot, own)?.finish(observer);
    }
    if own.is_some() {
        return Err(Error::Usage(format!(
            "{}: the folder holds several starts, but the caller's optimisation can continue only one; name the folder \
            of one start",
            folder.display()
        )));
    }
    multistart::search(lock, &snapshot.plan, observer)
}

/// Writes the result of an unfinished run for its current robot into the folder `into`, which is new, empty, or holds
/// an earlier result of this run. An earlier result is overwritten; the run itself does not change. For a run with the
/// caller's loss, `codesign` must have that loss.
///
/// # Errors
/// [`Error::Usage`] for a finished run, for several starts, before the first iteration, and if `into` holds anything
/// but an earlier delivery of this run; otherwise like [`resume`].
pub fn deliver_so_far(
    folder: &Path,
    into: &Path,
    codesign: Option<CoDesign>,
    registry: &Registry,
) -> Result<Summary> {
    let refused = |says: &str| Err(Error::Usage(format!("{}: {says}", folder.display())));
    let Some((_lock, snapshot)) = take_up(folder, registry)? else {
        return refused("the run is finished; its result is already in the folder");
    };
    let Some(progress) = snapshot.progress.as_ref() else {
        return refused("the folder holds several starts; name the folder of one start");
    };
    let done = progress.iteration - progress.before_first();
    let Some(done) = NonZeroUsize::new(done) else {
        return refused("the run has not done any iteration yet, so there is no robot to deliver");
    };
    let codesign = codesign.map_or_else(|| CoDesign::new(&snapshot.plan.scene), Ok)?;
    // All checks come before the first write.
    snapshot.clone().unpack(&folder.join(SNAPSHOT), &codesign)?;
    let lock = begin_or_replace(into, folder)?;
    let mut plan = snapshot.plan.clone();
    plan.iterations = Some(done);
    copy_files(folder, into, &[LINES, TABLE, DESIGNS])?;
    Snapshot::save(into, &plan, snapshot.seconds, Some(progress))?;
    let copy = Snapshot::read(into, registry)?;
    Run::open(lock, copy, Some(codesign))?.finish(&mut ())
}

/// Locks the folder `into`, which must be new, empty, or hold an earlier delivery of the run. Removes the summary of
/// the earlier delivery. The folder then counts as an unfinished run until the new summary is written.
fn begin_or_replace(into: &Path, run: &Path) -> Result<Lock> {
    if !is_earlier_delivery(into, run) {
        return begin(into);
    }
    let lock = Lock::take(into)?;
    let summary = into.join(SUMMARY);
    match fs::remove_file(&summary) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(Error::writing(summary)(error)),
        _ => Ok(lock),
    }
}

/// True if `into` holds an earlier delivery of the run: its history is the beginning of the run's history. The lines of
/// a history contain wall times, so the histories of two runs are never equal.
fn is_earlier_delivery(into: &Path, run: &Path) -> bool {
    let own = |folder: &Path| folder.canonicalize().ok();
    if own(into) == own(run) {
        return false;
    }
    let [earlier, whole] = [into, run].map(|folder| fs::read(folder.join(LINES)));
    let (Ok(earlier), Ok(whole)) = (earlier, whole) else {
        return false;
    };
    !earlier.is_empty() && whole.starts_with(&earlier)
}

/// Sets `unstable_step = "warn"` in the scene of a run and of all its starts. A finished run does not change.
///
/// # Errors
/// The errors of reading and writing a snapshot; [`Error::Usage`] if `scene.toml` is not the scene with which the run
/// began; [`Error::Taken`] if another process uses the folder.
pub fn allow_unstable(folder: &Path, registry: &Registry) -> Result<()> {
    let Some((_lock, mut snapshot)) = take_up(folder, registry)? else {
        return Ok(());
    };
    if snapshot.progress.as_ref().is_some_and(|p| p.own_loss) {
        return Err(Error::OwnLoss {
            file: folder.display().to_string(),
            remedy: "must begin a new run, with `physics.unstable_step = \"warn\"` in its scene",
        });
    }
    if snapshot.plan.scene.physics.unstable_step != UnstableStep::Warn {
        let scene = folder.join(SCENE);
        keep_scene(folder, &snapshot.plan.scene)?;
        // In this order a crash cannot leave a scene file that differs from the snapshot: the file does not exist while
        // the snapshot changes, and a missing file is written again from the snapshot.
        fs::remove_file(&scene).map_err(Error::writing(scene))?;
        snapshot.plan.scene.physics.unstable_step = UnstableStep::Warn;
        snapshot.write(folder)?;
        keep_scene(folder, &snapshot.plan.scene)?;
    }
    let starts = multistart::begun(folder, &snapshot.plan);
    let mut starts = starts.iter();
    starts.try_for_each(|start| allow_unstable(start, registry))
}

#[cfg(test)]
mod tests {
    use super::{deliver_so_far, optimise, optimise_with, resume_of, resume_with};
    use crate::Registry;
    use crate::codesign::tests::tiny;
    use crate::codesign::{CoDesign, Record};
    use crate::objective::Loss;
    use crate::record::{Observer, Run, RunPlan, history};
    use crate::simulator::Trajectory;
    use autodiff::Real;
    use std::collections::BTreeMap;
    use std::fs;
    use std::ops::ControlFlow;
    use std::path::Path;

    /// Interrupts a run after an iteration.
    struct StopAfter(usize);

    impl Observer for StopAfter {
        fn iteration(&mut self, _: &Run, record: &Record) -> ControlFlow<()> {
            if record.iteration == self.0 {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        }
    }

    /// A loss that is always NaN, with a finite gradient.
    struct Lost;

    impl Loss for Lost {
        fn observed(&self, steps: usize) -> Vec<usize> {
            vec![steps]
        }

        fn loss<R: Real>(&self, trajectory: &Trajectory<R>) -> R {
            trajectory.states[0].x[0][1] + R::lit(f64::NAN)
        }
    }

    /// Collects the warnings of a run.
    struct Warned(Vec<String>);

    impl Observer for Warned {
        fn warning(&mut self, _: &Run, text: &str) {
            self.0.push(text.to_owned());
        }
    }

    #[test]
    fn a_run_without_a_finite_loss_warns_and_ends_also_after_resuming() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let plan = RunPlan::new("tiny", tiny(), 1);
        let lost = || CoDesign::with_loss(&plan.scene, Lost).unwrap();
        let mut watch = Warned(Vec::new());
        let progress = lost().begin(1).unwrap();
        let error = optimise_with(&run, &plan, lost(), progress, &mut watch).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        let says = error.to_string();
        assert!(
            says.contains("the loss; after iteration 10 it is NaN"),
            "{says}"
        );
        let lost_in = |text: &&String| text.contains("after iteration 1: the loss is NaN");
        assert_eq!(watch.0.iter().filter(lost_in).count(), 1, "{:?}", watch.0);
        assert_eq!(history::read(&run, usize::MAX).unwrap().len(), 10);
        assert!(!run.join("design.json").exists());
        let again = resume_with(&run, lost(), &mut ()).unwrap_err().to_string();
        assert_eq!(again, says);
    }

    /// The files of a folder.
    fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
        let file = |entry: fs::DirEntry| {
            let name = entry.file_name().into_string().unwrap();
            (name, fs::read(entry.path()).unwrap())
        };
        entries.map(file).collect()
    }

    #[test]
    fn a_delivery_overwrites_no_other_run_and_no_other_files() {
        let folder = tempfile::tempdir().unwrap();
        let [run, other, foreign, into] =
            ["run", "other", "foreign", "into"].map(|name| folder.path().join(name));
        let plan = |seed| RunPlan::new("tiny", tiny(), seed);
        optimise(&run, &plan(1), &mut StopAfter(4)).unwrap_err();
        optimise(&other, &plan(2), &mut StopAfter(6)).unwrap_err();
        fs::create_dir(&foreign).unwrap();
        fs::write(foreign.join("history.csv"), "my own").unwrap();
        // The folder of the run itself is refused too, because a delivery would end the run.
        for into in [&other, &foreign, &run] {
            let before = files(into);
            let error = deliver_so_far(&run, into, None, &Registry::default()).unwrap_err();
            assert_eq!(error.exit_code(), 2);
            assert!(error.to_string().contains("not empty"), "{error}");
            assert_eq!(files(into), before);
        }
        assert_eq!(
            deliver_so_far(&run, &into, None, &Registry::default())
                .unwrap()
                .iterations,
            4
        );
        // The run continues, and is then delivered into the same folder again.
        resume_of(&run, &plan(1), &mut StopAfter(6)).unwrap_err();
        assert_eq!(
            deliver_so_far(&run, &into, None, &Registry::default())
                .unwrap()
                .iterations,
            6
        );
        // A delivery of another run is not overwritten.
        let before = files(&into);
        deliver_so_far(&other, &into, None, &Registry::default()).unwrap_err();
        assert_eq!(files(&into), before);
    }

    #[test]
    fn a_run_of_another_plan_is_not_resumed() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let plan = RunPlan::new("tiny", tiny(), 1);
        optimise(&run, &plan, &mut StopAfter(4)).unwrap_err();
        let before = files(&run);
        let mut other = plan.clone();
        other.scene.physics.gravity = 1.0;
        let error = resume_of(&run, &other, &mut ()).unwrap_err();
        assert!(error.to_string().contains("holds another run"), "{error}");
        assert_eq!(files(&run), before);
        assert_eq!(resume_of(&run, &plan, &mut ()).unwrap().iterations, 12);
    }
}
