//! Beginning runs in folders, and continuing them.

use super::files::{copy_files, make_folder};
use super::history::{DESIGNS, LINES, TABLE};
use super::multistart;
use super::run::{Observer, Run, SCENE, keep_scene, take_up};
use super::snapshot::{RunPlan, Snapshot};
use super::summary::Summary;
use crate::codesign::{CoDesign, Progress};
use crate::error::{Error, Result};
use crate::scene::UnstableStep;
use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;

/// Carries out a plan in a new or empty folder.
///
/// # Errors
/// [`Error::Usage`] for a folder that is not empty or that another process works in, and for a plan
/// that cannot be carried out; those of [`Scene::check`](crate::scene::Scene::check);
/// [`Error::UnstableStep`] if the time step is unstable for the start, [`Error::UnstableRun`] if it
/// becomes so later, unless the scene allows that; [`Error::Write`]; [`Error::Interrupted`] if the
/// observer asked for it; [`Error::Diverged`] if the delivered design diverges, with its last
/// states in the folder.
pub fn optimise(folder: &Path, plan: &RunPlan, observer: &mut dyn Observer) -> Result<Summary> {
    if plan.starts.get() == 1 {
        return Run::create(folder, plan)?.finish(observer);
    }
    let lock = multistart::create(folder, plan)?;
    multistart::search(lock, plan, observer)
}

/// Carries out a plan of one start with the caller's optimisation: for a [loss](CoDesign::with_loss)
/// other than the scene's, or from a given [robot](CoDesign::begin_with), which is saved as
/// `start.json`.
///
/// # Errors
/// As [`optimise`], and [`Error::Usage`] if the optimisation has another scene or seed than the
/// plan.
pub fn optimise_with(
    folder: &Path,
    plan: &RunPlan,
    codesign: CoDesign,
    progress: Progress,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    if plan.starts.get() > 1 {
        return Err(Error::Usage("several starts have a beginning each".into()));
    }
    let first = codesign.first(plan.seed)?;
    let is_of_plan = (codesign.scene(), progress.seed) == (&plan.scene, plan.seed);
    if !is_of_plan || progress.own_loss != first.own_loss {
        return Err(Error::Usage(
            "the optimisation and its progress are not both of the plan's scene and seed, and of one \
             loss"
                .into(),
        ));
    }
    progress.fits(&first, "the progress to begin with")?;
    if progress.iteration != progress.before_first() {
        return Err(Error::Usage(format!(
            "the progress to begin with has iterations behind it: {}",
            progress.iteration
        )));
    }
    Run::begin(folder, plan, codesign, progress)?.finish(observer)
}

/// As [`resume`], for a run with the caller's loss: `codesign` has to have that loss.
///
/// # Errors
/// As [`resume`], and [`Error::Usage`] if the optimisation has another scene than the run, or if the
/// folder holds several starts.
pub fn resume_with(
    folder: &Path,
    codesign: CoDesign,
    observer: &mut dyn Observer,
) -> Result<Summary> {
    let Some((lock, snapshot)) = take_up(folder)? else {
        return Summary::read(folder);
    };
    if snapshot.progress.is_none() {
        return Err(Error::Usage(format!(
            "{}: several starts, which have an optimisation each",
            folder.display()
        )));
    }
    Run::open_with(lock, snapshot, codesign)?.finish(observer)
}

/// Continues the run in a folder. A finished run is only read.
///
/// # Errors
/// [`Error::Read`] if there is no run, [`Error::Malformed`] or [`Error::Misfit`] for a damaged
/// snapshot, otherwise as [`optimise`].
pub fn resume(folder: &Path, observer: &mut dyn Observer) -> Result<Summary> {
    let Some((lock, snapshot)) = take_up(folder)? else {
        return Summary::read(folder);
    };
    if snapshot.progress.is_none() {
        return multistart::search(lock, &snapshot.plan, observer);
    }
    Run::open(lock, snapshot)?.finish(observer)
}

/// Delivers the robot of an unfinished run as it stands, in a new folder: the run itself stays as it is. Of a
/// run with the caller's loss, `codesign` has to have that loss.
///
/// # Errors
/// [`Error::Usage`] for a finished run, for several starts and before the first iteration; otherwise as
/// [`resume`].
pub fn deliver_so_far(folder: &Path, into: &Path, codesign: Option<CoDesign>) -> Result<Summary> {
    let refused = |says: &str| Err(Error::Usage(format!("{}: {says}", folder.display())));
    let Some((_lock, snapshot)) = take_up(folder)? else {
        return refused("the run is finished");
    };
    let Some(progress) = snapshot.progress.as_deref() else {
        return refused("several starts: name the folder of one");
    };
    let done = progress.iteration - progress.before_first();
    let Some(done) = NonZeroUsize::new(done) else {
        return refused("no iteration is done yet");
    };
    let mut plan = RunPlan::clone(&snapshot.plan);
    plan.iterations = Some(done);
    make_folder(into)?;
    copy_files(folder, into, &[LINES, TABLE, DESIGNS])?;
    Snapshot::save(into, &plan, snapshot.seconds, Some(progress))?;
    match codesign {
        None => resume(into, &mut ()),
        Some(codesign) => resume_with(into, codesign, &mut ()),
    }
}

/// Sets `unstable_step = "warn"` in the scene of a run and of all its starts. A finished run does
/// not change.
///
/// # Errors
/// The errors of reading and writing a snapshot; [`Error::Usage`] if `scene.toml` is not the scene that
/// the run began with; [`Error::Taken`] if another process works on the run.
pub fn allow_unstable(folder: &Path) -> Result<()> {
    let Some((_lock, mut snapshot)) = take_up(folder)? else {
        return Ok(());
    };
    if snapshot.progress.as_ref().is_some_and(|p| p.own_loss) {
        return Err(Error::OwnLoss {
            file: folder.display().to_string(),
            remedy: "begins anew, with `physics.unstable_step = \"warn\"` in its scene",
        });
    }
    if snapshot.plan.scene.physics.unstable_step != UnstableStep::Warn {
        let scene = folder.join(SCENE);
        keep_scene(folder, &snapshot.plan.scene)?;
        // In this order a crash never leaves a scene that differs from the snapshot: the scene is
        // gone until the new snapshot is written, and is written from a snapshot.
        fs::remove_file(&scene).map_err(Error::writing(scene))?;
        snapshot.plan.to_mut().scene.physics.unstable_step = UnstableStep::Warn;
        snapshot.write(folder)?;
        keep_scene(folder, &snapshot.plan.scene)?;
    }
    (multistart::begun(folder, &snapshot.plan).iter()).try_for_each(|start| allow_unstable(start))
}
