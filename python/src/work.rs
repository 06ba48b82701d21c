//! Work in other threads. Meanwhile the calling thread handles signals, and passes on what the work reports.

use crate::errors::{caught, panicked, raised};
use cosmic::parallel::pool;
use cosmic::world::together;
use pyo3::prelude::*;
use rayon::ThreadPool;
use rayon::prelude::*;
use std::ops::Range;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// Something that a process makes once. A forked process gets a copy without threads and devices, so it makes a new one.
pub(crate) struct OfProcess<T>(Mutex<Option<(u32, Arc<T>)>>);

impl<T> OfProcess<T> {
    pub(crate) const fn new() -> Self {
        Self(Mutex::new(None))
    }

    pub(crate) fn get(&self, make: impl FnOnce() -> PyResult<T>) -> PyResult<Arc<T>> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let process = process::id();
        if let Some((owner, made)) = &*kept
            && *owner == process
        {
            return Ok(Arc::clone(made));
        }
        let made = Arc::new(make()?);
        *kept = Some((process, Arc::clone(&made)));
        Ok(made)
    }
}

/// The thread pool that simulates batches of robots.
static POOL: OfProcess<ThreadPool> = OfProcess::new();

fn shared() -> PyResult<Arc<ThreadPool>> {
    POOL.get(|| pool(None).map_err(raised))
}

/// Returns the default number of threads: one per core, or as many as `RAYON_NUM_THREADS` says.
#[pyfunction]
pub(crate) fn usual_threads() -> PyResult<usize> {
    caught(|| Ok(shared()?.current_num_threads()))
}

/// The interval between checks for signals.
const LOOK: Duration = Duration::from_millis(50);

/// The result of work, and the exception that a signal or a listener raised during the work, if any.
pub(crate) type Interruptible<T> = (T, Option<PyErr>);

/// Runs work in a pool. Meanwhile, the current thread handles signals and the events that the work sends. The first
/// exception sets `stop`.
pub(crate) fn attended<E: Send, T: Send>(
    py: Python,
    pool: &ThreadPool,
    stop: &AtomicBool,
    hear: impl Fn(E) -> PyResult<()>,
    work: impl FnOnce(Sender<E>) -> T + Send,
) -> PyResult<Interruptible<T>> {
    let (events, mut heard) = channel();
    thread::scope(|scope| {
        // The end of the work drops the sender, which ends the loop.
        let worker = scope.spawn(move || pool.install(move || work(events)));
        let mut raised = None;
        loop {
            let receiver = &mut heard;
            let handled = match py.detach(move || receiver.recv_timeout(LOOK)) {
                Ok(event) if raised.is_none() => hear(event),
                Ok(_) | Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if let Err(error) = handled.and_then(|()| py.check_signals()) {
                stop.store(true, Ordering::Relaxed);
                raised.get_or_insert(error);
            }
        }
        let done = py.detach(|| worker.join());
        Ok((done.map_err(|panic| panicked(&*panic))?, raised))
    })
}

/// A flag that becomes true when the work must stop. Robots that have not begun by then are skipped.
pub(crate) type Stop = AtomicBool;

/// Runs `work` in a thread without the interpreter's lock. If there are several robots, it runs in the thread pool, and a
/// signal stops it after the robots in progress. Only the main thread of Python notices signals. It takes the lock for
/// this, but not before the work has taken some time.
pub(crate) fn in_pool<T: Send>(
    robots: usize,
    work: impl FnOnce(&Stop) -> T + Send,
) -> PyResult<Interruptible<T>> {
    let stop = Stop::new(false);
    if robots == 1 {
        return Ok((work(&stop), None));
    }
    let pool = shared()?;
    let (running, ended) = channel::<()>();
    thread::scope(|scope| {
        let worker = scope.spawn(|| {
            let _until_the_end = running;
            pool.install(|| work(&stop))
        });
        let mut raised = None;
        while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
            if let Some(Err(error)) = Python::try_attach(|py| py.check_signals()) {
                stop.store(true, Ordering::Relaxed);
                raised.get_or_insert(error);
            }
        }
        let done = worker.join().map_err(|panic| panicked(&*panic))?;
        Ok((done, raised))
    })
}

/// Returns the result of work. If a signal interrupted the work, drops the partial result and returns the exception.
pub(crate) fn whole<T>((done, raised): Interruptible<T>) -> PyResult<T> {
    raised.map_or(Ok(done), Err)
}

/// Returns the number of robots that a thread simulates together: several if they share the controller, otherwise one.
/// For a single robot, the function starts no thread pool to count its threads.
pub(crate) fn group_size(robots: usize, shared: bool) -> usize {
    if robots > 1 && shared {
        together(robots)
    } else {
        1
    }
}

/// Applies a function to every group of `size` robots, and returns the results. Groups that have not begun when the work
/// is stopped are skipped.
pub(crate) fn each<T: Send>(
    robots: usize,
    size: usize,
    stop: &Stop,
    of: impl Fn(Range<usize>) -> T + Sync + Send,
) -> Vec<T> {
    let group = |k: usize| of(k * size..((k + 1) * size).min(robots));
    if robots == 1 {
        return vec![group(0)];
    }
    let groups = (0..robots.div_ceil(size)).into_par_iter();
    groups
        .filter_map(|k| (!stop.load(Ordering::Relaxed)).then(|| group(k)))
        .collect()
}
