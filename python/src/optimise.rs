//! Runs in folders, with the interpreter alive: progress and signals reach the calling thread.

use crate::errors::{raised, refused};
use crate::loss::{Failure, PythonLoss, taken};
use crate::pool;
use crate::scene::Scene;
use cosmic::codesign::{CoDesign, Record};
use cosmic::error::{Error, Result};
use cosmic::record::{self, DesignFile, Observer, Run, RunPlan};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::num::NonZeroUsize;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

/// How often signals are looked for.
const LOOK: Duration = Duration::from_millis(50);

/// What the calling thread is told.
enum Event {
    Iteration { last: usize, record: Box<Record> },
    Warning(String),
}

/// Passes on what a run does, and the wish to stop.
struct Watch {
    events: Sender<Event>,
    stop: Arc<AtomicBool>,
    failure: Failure,
}

impl Watch {
    fn send(&self, event: Event) {
        // Nobody listens any more only where the process is about to end.
        let _ = self.events.send(event);
    }
}

impl Observer for Watch {
    fn iteration(&mut self, run: &Run, record: &Record) -> ControlFlow<()> {
        let last = run.last_iteration();
        self.send(Event::Iteration {
            last,
            record: Box::new(record.clone()),
        });
        let failed = self.failure.lock().is_ok_and(|failure| failure.is_some());
        if failed || self.stop.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(())
    }

    fn warning(&mut self, _: &Run, text: &str) {
        self.send(Event::Warning(text.to_owned()));
    }
}

/// What Python hears of a run: `progress(iteration, last, numbers)`, `warning(text)`.
struct Listener<'a, 'py> {
    progress: Option<&'a Bound<'py, PyAny>>,
    warning: &'a Bound<'py, PyAny>,
}

impl Listener<'_, '_> {
    fn hear(&self, py: Python, event: Event) -> PyResult<()> {
        match event {
            Event::Warning(text) => self.warning.call1((text,)).map(drop),
            Event::Iteration { last, record } => {
                let Some(progress) = self.progress else {
                    return Ok(());
                };
                let numbers = PyDict::new(py);
                numbers.set_item("phase", record.phase.name())?;
                numbers.set_item("displacement", record.displacement)?;
                numbers.set_item("V", record.volume)?;
                numbers.set_item("V_act", record.actuator_volume)?;
                progress.call1((record.iteration, last, numbers)).map(drop)
            }
        }
    }
}

/// Does the work on other threads while this one passes on progress and signals. Returns true if the work
/// was interrupted by a signal.
fn attended(
    py: Python,
    threads: usize,
    failure: &Failure,
    listener: &Listener,
    work: impl FnOnce(&mut dyn Observer) -> Result<()> + Send + 'static,
) -> PyResult<bool> {
    let (events, mut heard) = channel();
    let stop = Arc::new(AtomicBool::new(false));
    let mut watch = Watch {
        events,
        stop: Arc::clone(&stop),
        failure: Arc::clone(failure),
    };
    let pool = pool::made(threads)?;
    // The sender is dropped with the work: then there is nothing more to hear.
    let worker = thread::spawn(move || pool.install(move || work(&mut watch)));
    let raised_here = attend(py, &mut heard, &stop, listener);
    let ended = py.detach(|| worker.join());
    if let Some(error) = taken(failure) {
        return Err(error);
    }
    let ended = ended.map_err(|panic| {
        let says = panic.downcast_ref::<String>().map(String::as_str);
        let says = says
            .or(panic.downcast_ref::<&str>().copied())
            .unwrap_or("no message");
        PyRuntimeError::new_err(format!("the library panicked: {says}"))
    })?;
    match (ended, raised_here) {
        // A run that ended all the same is a run.
        (Ok(()), None) => Ok(false),
        (Ok(()), Some(error)) if is_interrupt(py, &error) => Ok(false),
        (Err(Error::Interrupted { .. }), Some(error)) if is_interrupt(py, &error) => Ok(true),
        (_, Some(error)) => Err(error),
        (Err(error), None) => Err(raised(error)),
    }
}

fn is_interrupt(py: Python, error: &PyErr) -> bool {
    error.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py)
}

/// Hears events until the work is over. The first exception on the way stops the work and is returned.
fn attend(
    py: Python,
    heard: &mut Receiver<Event>,
    stop: &AtomicBool,
    listener: &Listener,
) -> Option<PyErr> {
    let mut first = None;
    loop {
        let receiver = &mut *heard;
        let next = py.detach(move || receiver.recv_timeout(LOOK));
        let done = match next {
            Ok(event) if first.is_none() => listener.hear(py, event),
            Ok(_) | Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => return first,
        };
        if let Err(error) = done.and_then(|()| py.check_signals()) {
            stop.store(true, Ordering::Relaxed);
            first.get_or_insert(error);
        }
    }
}

/// The optimisation of a scene, for a loss of Python if there is one.
fn codesign(
    scene: &cosmic::scene::Scene,
    loss: Option<Py<PyAny>>,
    failure: &Failure,
) -> Result<CoDesign> {
    match loss {
        None => CoDesign::new(scene),
        Some(object) => CoDesign::with_loss(scene, PythonLoss::new(object, Arc::clone(failure))),
    }
}

/// The exception of a loss comes before what it led to.
fn or_failure<T>(failure: &Failure, result: Result<T>) -> PyResult<T> {
    result.map_err(|error| taken(failure).unwrap_or_else(|| raised(error)))
}

/// Begins a run in a new or empty folder and carries it out. Returns true if a signal interrupted it.
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
    let failure = Failure::default();
    let iterations = iterations.map(|n| {
        NonZeroUsize::new(n).ok_or_else(|| refused("iterations: expected 1 or more".to_owned()))
    });
    let plan = RunPlan {
        iterations: iterations.transpose()?,
        ..RunPlan::new(&name, scene.scene.clone(), seed)
    };
    let begun = py.detach(|| {
        let codesign = codesign(&plan.scene, loss, &failure)?;
        let progress = match begin_with {
            None => codesign.begin(plan.seed),
            Some(path) => {
                let design = DesignFile::read(&path)?;
                let controller = design.robot(&plan.scene, &path.display().to_string())?;
                codesign.begin_with(plan.seed, design.z, controller)
            }
        }?;
        Ok((codesign, progress))
    });
    let (codesign, start) = or_failure(&failure, begun)?;
    let listener = Listener {
        progress: progress.as_ref(),
        warning: &warning,
    };
    attended(py, threads, &failure, &listener, move |observer| {
        record::optimise_with(&folder, &plan, codesign, start, observer).map(drop)
    })
}

/// Continues the run in a folder. Returns true if a signal interrupted it.
#[pyfunction]
pub(crate) fn resume(
    py: Python,
    folder: PathBuf,
    loss: Option<Py<PyAny>>,
    threads: usize,
    progress: Option<Bound<PyAny>>,
    warning: Bound<PyAny>,
) -> PyResult<bool> {
    let failure = Failure::default();
    let own = own(py, &folder, loss, &failure)?;
    let listener = Listener {
        progress: progress.as_ref(),
        warning: &warning,
    };
    attended(py, threads, &failure, &listener, move |observer| {
        match own {
            None => record::resume(&folder, observer),
            Some(codesign) => record::resume_with(&folder, codesign, observer),
        }
        .map(drop)
    })
}

/// Delivers the robot of an unfinished run as it stands in another folder.
#[pyfunction]
pub(crate) fn deliver_so_far(
    py: Python,
    folder: PathBuf,
    into: PathBuf,
    loss: Option<Py<PyAny>>,
) -> PyResult<()> {
    let failure = Failure::default();
    let own = own(py, &folder, loss, &failure)?;
    let done = py.detach(|| record::deliver_so_far(&folder, &into, own));
    or_failure(&failure, done).map(drop)
}

/// The optimisation of the scene in a run's folder for a loss of Python, if there is one.
fn own(
    py: Python,
    folder: &Path,
    loss: Option<Py<PyAny>>,
    failure: &Failure,
) -> PyResult<Option<CoDesign>> {
    if loss.is_none() {
        return Ok(None);
    }
    let scene = folder.join(record::run::SCENE);
    let made = py.detach(|| codesign(&cosmic::scene::Scene::read(&scene)?, loss, failure));
    or_failure(failure, made).map(Some)
}
