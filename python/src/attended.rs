//! Runs work in another thread, so that progress and signals reach the calling thread.

use crate::errors::{in_python, panicked, raised};
use crate::loss::Failure;
use crate::pool;
use cosmic::codesign::Record;
use cosmic::error::{Error, Result};
use cosmic::record::{Observer, Run};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;

/// The interval between checks for signals.
const LOOK: Duration = Duration::from_millis(50);

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

impl Watch {
    fn send(&self, event: Event) {
        // Sending fails only if the process is about to end.
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
        match self.is_stopped() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        Some(Arc::clone(&self.stop))
    }

    fn warning(&mut self, _: &Run, text: &str) {
        self.send(Event::Warning(text.to_owned()));
    }
}

/// The Python functions to call during a run: `progress(iteration, last, numbers)` and `warning(text)`.
#[derive(Default)]
pub(crate) struct Listener<'a, 'py> {
    pub(crate) progress: Option<&'a Bound<'py, PyAny>>,
    pub(crate) warning: Option<&'a Bound<'py, PyAny>>,
}

impl Listener<'_, '_> {
    fn hear(&self, py: Python, event: Event) -> PyResult<()> {
        match event {
            Event::Warning(text) => {
                let tell = |warning: &Bound<PyAny>| warning.call1((in_python(text),)).map(drop);
                self.warning.map_or(Ok(()), tell)
            }
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

/// Does the work on other threads. Meanwhile, the current thread reports progress to the listener and handles signals.
/// Returns `None` if a signal interrupted the work. If other code sets the shared `stop`, the work ends with an error.
pub(crate) fn attended<T: Send + 'static>(
    py: Python,
    threads: usize,
    failure: &Failure,
    listener: &Listener,
    stop: Arc<AtomicBool>,
    work: impl FnOnce(&mut Watch) -> Result<T> + Send + 'static,
) -> PyResult<Option<T>> {
    let (events, mut heard) = channel();
    let mut watch = Watch {
        events,
        stop: Arc::clone(&stop),
    };
    let pool = pool::made(threads)?;
    // The end of the work drops its sender, which ends the loop of `attend`.
    let worker = thread::spawn(move || pool.install(move || work(&mut watch)));
    let raised_here = attend(py, &mut heard, &stop, listener);
    let ended = py.detach(|| worker.join());
    if let Some(error) = failure.taken() {
        return Err(error);
    }
    let ended = ended.map_err(|panic| panicked(&*panic))?;
    match (ended, raised_here) {
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

/// Handles events and signals until the work is done. The first exception stops the work and is returned.
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
