//! The thread pool that simulates batches of robots.

use crate::errors::{Error, refused};
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::process;
use std::sync::{Arc, Mutex};

/// The pool, with the number of the process that made it. A forked process gets a copy of the pool without its threads,
/// so it must make a new pool.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Returns the pool of this process, which has one thread per core, or as many as `RAYON_NUM_THREADS` says.
pub(crate) fn shared() -> PyResult<Arc<ThreadPool>> {
    let mut kept = POOL.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let process = process::id();
    if let Some((owner, pool)) = &*kept
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let pool = Arc::new(made(0)?);
    *kept = Some((process, Arc::clone(&pool)));
    Ok(pool)
}

/// The maximum number of threads. To start more threads takes longer than a run.
const MOST: usize = 1024;

/// Returns the default number of threads: one per core, or as many as `RAYON_NUM_THREADS` says.
#[pyfunction]
pub(crate) fn usual_threads() -> PyResult<usize> {
    Ok(shared()?.current_num_threads())
}

/// Starts a thread pool with `threads` threads; 0 means [the default](usual_threads).
pub(crate) fn made(threads: usize) -> PyResult<ThreadPool> {
    if threads > MOST {
        return Err(refused(format!("threads: {threads}: allowed: 1 to {MOST}")));
    }
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| {
        Error::new_err(format!(
            "cannot start {threads} threads: {error}; choose fewer with `threads`"
        ))
    })
}
