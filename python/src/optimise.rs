//! Does, resumes and delivers runs in folders.

use crate::attended::{Listener, Watch, attended};
use crate::errors::{caught, raised, refused};
use crate::loss::{Failure, PythonLoss};
use crate::memory::optimisation_fits;
use crate::scene::Scene;
use cosmic::Registry;
use cosmic::codesign::CoDesign;
use cosmic::error::Result;
use cosmic::record::{self, DesignFile, RunPlan};
use pyo3::prelude::*;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Prepares the optimisation of a scene, with a Python loss if there is one.
fn codesign(
    scene: &cosmic::scene::Scene,
    loss: Option<Py<PyAny>>,
    failure: &Failure,
) -> Result<CoDesign> {
    match loss {
        None => CoDesign::new(scene),
        Some(object) => CoDesign::with_loss(scene, PythonLoss::new(object, failure.clone())),
    }
}

/// Converts an error of the library to an exception. If the loss raised an exception, that one is returned, because it
/// caused the error.
fn or_failure<T>(failure: &Failure, result: Result<T>) -> PyResult<T> {
    result.map_err(|error| failure.taken().unwrap_or_else(|| raised(error)))
}

/// Does a run in a new or empty folder. Returns true if a signal interrupted it.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the signature of Python")]
pub(crate) fn optimise(
    py: Python,
    scene: &Scene,
    name: String,
    seed: u64,
    iterations: Option<usize>,
    folder: PathBuf,
    begin_with: Option<PathBuf>,
    loss: Option<Py<PyAny>>,
    threads: usize,
    progress: Option<Bound<PyAny>>,
    warning: Bound<PyAny>,
) -> PyResult<bool> {
    let stop = Arc::default();
    let failure = Failure::that_stops(&stop);
    let iterations = iterations.map(|n| {
        NonZeroUsize::new(n).ok_or_else(|| refused("iterations: expected 1 or more".to_owned()))
    });
    let iterations = iterations.transpose()?;
    let given = scene.scene.clone();
    let read = || -> Result<(RunPlan, Option<DesignFile>)> {
        let read =
            |path: &Path| DesignFile::read(path)?.in_order(&given, &path.display().to_string());
        let design = begin_with.as_deref().map(read).transpose()?;
        let from = design.as_ref().map(DesignFile::design);
        let plan = RunPlan::new(&name, given.clone(), seed).fitted(iterations, from.as_ref())?;
        Ok((plan, design))
    };
    let (plan, design) = caught(|| py.detach(read).map_err(raised))?;
    optimisation_fits(&plan.scene)?;
    let begin = || {
        let codesign = codesign(&plan.scene, loss, &failure)?;
        let progress = match (&begin_with, &design) {
            (Some(path), Some(design)) => {
                let controller = design.robot(&plan.scene, &path.display().to_string())?;
                codesign.begin_with(plan.seed, design.design(), controller)
            }
            _ => codesign.begin(plan.seed),
        }?;
        Ok((codesign, progress))
    };
    let (codesign, start) = caught(|| or_failure(&failure, py.detach(begin)))?;
    for doubt in plan.scene.doubts() {
        warning.call1((doubt.to_string(),))?;
    }
    let listener = Listener {
        progress: progress.as_ref(),
        warning: Some(&warning),
    };
    let ended = attended(py, threads, &failure, &listener, stop, move |watch| {
        record::optimise_with(&folder, &plan, codesign, start, watch)
    })?;
    Ok(ended.is_none())
}

/// Continues the run in a folder. With `allow_unstable` the run continues even if its time step is unstable. Returns
/// true if a signal interrupted the run.
#[pyfunction]
pub(crate) fn resume(
    py: Python,
    folder: PathBuf,
    loss: Option<Py<PyAny>>,
    allow_unstable: bool,
    threads: usize,
    progress: Option<Bound<PyAny>>,
    warning: Bound<PyAny>,
) -> PyResult<bool> {
    let stop = Arc::default();
    let failure = Failure::that_stops(&stop);
    if allow_unstable {
        caught(|| {
            py.detach(|| record::allow_unstable(&folder, &Registry::default()))
                .map_err(raised)
        })?;
    }
    let own = own(py, &folder, loss, &failure)?;
    let listener = Listener {
        progress: progress.as_ref(),
        warning: Some(&warning),
    };
    let go_on = move |watch: &mut Watch| match own {
        None => record::resume(&folder, &Registry::default(), watch),
        Some(codesign) => record::resume_with(&folder, codesign, watch),
    };
    let ended = attended(py, threads, &failure, &listener, stop, go_on)?;
    Ok(ended.is_none())
}

/// Writes the current robot of an unfinished run into another folder.
#[pyfunction]
pub(crate) fn deliver_so_far(
    py: Python,
    folder: PathBuf,
    into: PathBuf,
    loss: Option<Py<PyAny>>,
) -> PyResult<()> {
    let failure = Failure::default();
    let own = own(py, &folder, loss, &failure)?;
    let deliver = || record::deliver_so_far(&folder, &into, own, &Registry::default());
    caught(|| or_failure(&failure, py.detach(deliver)).map(drop))
}

/// Prepares the optimisation of a run's scene with a Python loss. Returns `None` if there is no Python loss.
fn own(
    py: Python,
    folder: &Path,
    loss: Option<Py<PyAny>>,
    failure: &Failure,
) -> PyResult<Option<CoDesign>> {
    if loss.is_none() {
        return Ok(None);
    }
    let make = || {
        codesign(
            &record::run::read_scene(folder, &Registry::default())?,
            loss,
            failure,
        )
    };
    caught(|| or_failure(failure, py.detach(make)).map(Some))
}
