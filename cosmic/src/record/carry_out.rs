//! The functions that begin, continue and deliver runs in folders.

use super::files::copy_files;
use super::history::{DESIGNS, LINES};
use super::multistart;
use super::run::{Observer, Run, SCENE, begin, keep_scene, read_scene, read_summary, take_up};
use super::snapshot::{RunPlan, SNAPSHOT, Snapshot};
use crate::error::{Error, Result};
use crate::outcome::Summary;
use crate::registry::Registry;
use crate::scene::UnstableStep;
use crate::search::{CoDesign, Progress};
use std::fs;
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
/// [`Error::Read`] if there is no run, [`Error::Malformed`] or [`Error::Misfit`] for a damaged snapshot, [`Error::Usage`]
/// if `scene.toml` is not the scene with which the run began, otherwise like [`optimise`].
pub fn resume(folder: &Path, registry: &Registry, observer: &mut dyn Observer) -> Result<Summary> {
    let resumed = resume_if(folder, registry, |_| Ok(()), None, observer)?;
    resumed.map_or_else(|| finished(folder, registry), Ok)
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
    let resumed = resume_if(folder, &registry, |_| Ok(()), Some(codesign), observer)?;
    resumed.map_or_else(|| finished(folder, &registry), Ok)
}

/// Reads the summary of a finished run.
fn finished(folder: &Path, registry: &Registry) -> Result<Summary> {
    let summary = read_summary(folder)?;
    // A summary can be read without a scene, but not beside a wrong one.
    if folder.join(SCENE).exists() {
        read_scene(folder, registry)?;
    }
    Ok(summary)
}

/// Like [`resume`], but only if the run in the folder has the plan `plan`. Returns `None` if the run is finished.
///
/// # Errors
/// Like [`resume`]; [`Error::Usage`] if the folder holds an unfinished run of another plan, which is left unchanged.
pub fn resume_of(
    folder: &Path,
    plan: &RunPlan,
    observer: &mut dyn Observer,
) -> Result<Option<Summary>> {
    let accept = |found: &RunPlan| found.check_same(plan, folder);
    resume_if(folder, plan.scene.registry(), accept, None, observer)
}

/// Continues the run in a folder if `accept` accepts its plan. If `own` is given, this optimisation of the caller is
/// used. Returns `None` if the run is finished.
fn resume_if(
    folder: &Path,
    registry: &Registry,
    accept: impl FnOnce(&RunPlan) -> Result<()>,
    own: Option<CoDesign>,
    observer: &mut dyn Observer,
) -> Result<Option<Summary>> {
    let Some((lock, snapshot)) = take_up(folder, registry)? else {
        return Ok(None);
    };
    accept(&snapshot.plan)?;
    if snapshot.progress.is_some() {
        return Run::open(lock, snapshot, own)?.finish(observer).map(Some);
    }
    if own.is_some() {
        return Err(Error::Usage(format!(
            "{}: the folder holds several starts, but the caller's optimisation can continue only one; name the folder \
            of one start",
            folder.display()
        )));
    }
    multistart::search(lock, &snapshot.plan, observer).map(Some)
}

/// Writes the result of an unfinished run for its current robot into the folder `into`, which is new or empty. The run
/// itself does not change. For a run with the caller's loss, `codesign` must have that loss.
///
/// # Errors
/// [`Error::Usage`] for a finished run, for several starts, before the first iteration, and if `into` is not
/// empty; otherwise like [`resume`].
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
    let lock = begin(into)?;
    let mut plan = snapshot.plan.clone();
    plan.iterations = Some(done);
    copy_files(folder, into, &[LINES, DESIGNS])?;
    Snapshot::save(into, &plan, snapshot.seconds, Some(progress))?;
    let copy = Snapshot::read(into, registry)?;
    Run::open(lock, copy, Some(codesign))?.finish(&mut ())
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
