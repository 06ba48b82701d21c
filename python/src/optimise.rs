//! Does, resumes and delivers runs in folders.

use crate::errors::{in_python, raised, unlocked};
use crate::loss::{Failure, PythonLoss};
use crate::scene::Scene;
use crate::work::attended;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::outcome::DesignFile;
use cosmic::parallel::pool;
use cosmic::record::{self, Observer, Run, RunPlan};
use cosmic::search::{CoDesign, Record};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::Sender;

/// A message from a run to the calling thread.
enum Event {
    Iteration { last: usize, record: Box<Record> },
    Warning(String),
}

/// Sends the progress of a run to the calling thread, and tells the run when to stop.
pub(crate) struct Watch {
    events: Sender<Event>,
    stop: Arc<AtomicBool>,
}

impl Observer for Watch {
    fn iteration(&mut self, run: &Run, record: &Record) -> ControlFlow<()> {
        let (last, record) = (run.last_iteration(), Box::new(record.clone()));
        // Sending fails only if the process is about to end.
        _ = self.events.send(Event::Iteration { last, record });
        ControlFlow::Continue(())
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(Arc::clone(&self.stop))
    }

    fn warning(&mut self, _: &Run, text: &str) {
        _ = self.events.send(Event::Warning(text.to_owned()));
    }
}

/// The Python functions to call during a run: `progress(iteration, last, numbers)` and `warning(text)`.
#[derive(Default)]
pub(crate) struct Listener<'py> {
    progress: Option<Bound<'py, PyAny>>,
    warning: Option<Bound<'py, PyAny>>,
}

impl Listener<'_> {
    fn hear(&self, py: Python, event: Event) -> PyResult<()> {
        match (event, &self.progress, &self.warning) {
            (Event::Warning(text), _, Some(warning)) => warning.call1((in_python(text),)).map(drop),
            (Event::Iteration { last, record }, Some(progress), _) => {
                let numbers = PyDict::new(py);
                numbers.set_item("phase", record.phase.name())?;
                numbers.set_item("displacement", record.displacement)?;
                numbers.set_item("V", record.volume)?;
                numbers.set_item("V_act", record.actuator_volume)?;
                progress.call1((record.iteration, last, numbers)).map(drop)
            }
            _ => Ok(()),
        }
    }
}

/// Does a run on `threads` threads, by default one per core. Meanwhile, the current thread reports progress to the listener and handles signals.
/// Returns `None` if a signal interrupted the run.
pub(crate) fn attended_run<T: Send>(
    py: Python,
    threads: Option<NonZeroUsize>,
    failure: &Failure,
    listener: &Listener,
    work: impl FnOnce(&mut Watch) -> Result<T> + Send,
) -> PyResult<Option<T>> {
    let stop = failure.stop();
    let hear = |event| listener.hear(py, event);
    let watched = |events| {
        let stop = Arc::clone(&stop);
        work(&mut Watch { events, stop })
    };
    let pool = pool(threads).map_err(raised)?;
    let ended = attended(py, &pool, &stop, hear, watched);
    if let Some(error) = failure.taken() {
        return Err(error);
    }
    match ended? {
        (Ok(done), None) => Ok(Some(done)),
        // The run finished before it saw the request to stop.
        (Ok(done), Some(error)) if is_interrupt(py, &error) => Ok(Some(done)),
        (Err(Error::Interrupted { .. } | Error::Stopped { .. }), Some(error))
            if is_interrupt(py, &error) =>
        {
            Ok(None)
        }
        (_, Some(error)) => Err(error),
        (Err(error), None) => Err(raised(error)),
    }
}

fn is_interrupt(py: Python, error: &PyErr) -> bool {
    error.is_instance_of::<PyKeyboardInterrupt>(py)
}

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

/// Prepares the optimisation of a run's scene with a Python loss. Returns `None` if there is no Python loss.
fn own(folder: &Path, loss: Option<Py<PyAny>>, failure: &Failure) -> Result<Option<CoDesign>> {
    let Some(loss) = loss else {
        return Ok(None);
    };
    let scene = record::run::read_scene(folder, &Registry::default())?;
    codesign(&scene, Some(loss), failure).map(Some)
}

/// Does work of the library that calls a loss. If the loss raised an exception, that one is returned, because it caused
/// the error.
fn with_loss<T: Send>(
    py: Python,
    failure: &Failure,
    work: impl FnOnce() -> Result<T> + Send,
) -> PyResult<T> {
    unlocked(py, work).map_err(|error| failure.taken().unwrap_or(error))
}

/// Does a run in a new or empty folder. Returns true if a signal interrupted it.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the signature of Python")]
pub(crate) fn optimise<'py>(
    py: Python<'py>,
    scene: &Scene,
    name: String,
    seed: u64,
    iterations: Option<NonZeroUsize>,
    folder: PathBuf,
    begin_with: Option<PathBuf>,
    loss: Option<Py<PyAny>>,
    threads: Option<NonZeroUsize>,
    progress: Option<Bound<'py, PyAny>>,
    warning: Bound<'py, PyAny>,
) -> PyResult<bool> {
    let failure = Failure::default();
    let given = scene.scene.clone();
    let prepare = || {
        let read =
            |path: &Path| DesignFile::read(path)?.in_order(&given, &path.display().to_string());
        let design = begin_with.as_deref().map(read).transpose()?;
        let from = design.as_ref().map(DesignFile::design);
        let plan = RunPlan::new(&name, given.clone(), seed).fitted(iterations, from.as_ref())?;
        let codesign = codesign(&plan.scene, loss, &failure)?;
        let progress = match (&begin_with, &design) {
            (Some(path), Some(design)) => {
                let controller = design.robot(&plan.scene, &path.display().to_string())?;
                codesign.begin_with(plan.seed, design.design(), controller)
            }
            _ => codesign.begin(plan.seed),
        }?;
        Ok((plan, codesign, progress))
    };
    let (plan, codesign, start) = with_loss(py, &failure, prepare)?;
    for finding in plan.scene.warnings() {
        warning.call1((finding.to_string(),))?;
    }
    let warning = Some(warning);
    let listener = Listener { progress, warning };
    let ended = attended_run(py, threads, &failure, &listener, |watch| {
        record::optimise_with(&folder, &plan, codesign, start, watch)
    })?;
    Ok(ended.is_none())
}

/// Continues the run in a folder. With `allow_unstable` the run continues even if its time step is unstable. Returns
/// true if a signal interrupted the run.
#[pyfunction]
pub(crate) fn resume<'py>(
    py: Python<'py>,
    folder: PathBuf,
    loss: Option<Py<PyAny>>,
    allow_unstable: bool,
    threads: Option<NonZeroUsize>,
    progress: Option<Bound<'py, PyAny>>,
    warning: Bound<'py, PyAny>,
) -> PyResult<bool> {
    let failure = Failure::default();
    let prepare = || {
        if allow_unstable {
            record::allow_unstable(&folder, &Registry::default())?;
        }
        own(&folder, loss, &failure)
    };
    let own = with_loss(py, &failure, prepare)?;
    let warning = Some(warning);
    let listener = Listener { progress, warning };
    let ended = attended_run(py, threads, &failure, &listener, |watch| match own {
        None => record::resume(&folder, &Registry::default(), watch),
        Some(codesign) => record::resume_with(&folder, codesign, watch),
    })?;
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
    with_loss(py, &failure, || {
        let own = own(&folder, loss, &failure)?;
        record::deliver_so_far(&folder, &into, own, &Registry::default()).map(drop)
    })
}
