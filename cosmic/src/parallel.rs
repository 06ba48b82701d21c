//! Runs independent jobs at the same time.

use crate::error::{Error, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

/// How jobs are divided among threads.
#[derive(Clone, Copy, Debug)]
pub struct ThreadPlan {
    /// The number of jobs that run at the same time.
    pub at_work: usize,
    /// The number of threads of each job.
    pub threads: usize,
}

impl ThreadPlan {
    /// A plan that runs `threads` jobs at the same time, each on a single thread. `None` runs one job per core.
    /// Parallel code within a job runs on the job's thread too.
    pub fn of_one(threads: Option<NonZeroUsize>) -> Self {
        let cores = || thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
        Self {
            at_work: threads.unwrap_or_else(cores).get(),
            threads: 1,
        }
    }

    /// A plan that divides `threads` among `jobs`. If there are fewer jobs than threads, each job gets several threads.
    pub fn shared_out(threads: usize, jobs: usize) -> Self {
        let at_work = threads.min(jobs).max(1);
        Self {
            at_work,
            threads: (threads / at_work).max(1),
        }
    }
}

/// Starts a pool of threads, by default one per core, or as many as `RAYON_NUM_THREADS` says.
///
/// # Errors
/// [`Error::Usage`] if the system does not start the threads.
pub fn pool(threads: Option<NonZeroUsize>) -> Result<ThreadPool> {
    // For rayon, 0 means the default.
    let count = threads.map_or(0, NonZeroUsize::get);
    let pool = ThreadPoolBuilder::new().num_threads(count).build();
    let what = threads.map_or("the threads".to_owned(), |count| format!("{count} threads"));
    let says = |error| format!("cannot start {what}: {error}; choose fewer threads");
    pool.map_err(|error| Error::Usage(says(error)))
}

/// The message of an `expect`: the lock on the results cannot be poisoned, because no thread panics while it holds the
/// lock.
const NO_PANIC: &str = "no push panics";

/// Calls `job` with the numbers 0 to `jobs - 1`, lower numbers first, and returns the results in the order of the
/// numbers. `job` also receives a flag. The flag becomes true as soon as another job has failed.
///
/// # Errors
/// The first error of a job. After it, no further job begins.
pub fn in_parallel<T: Send>(
    jobs: usize,
    plan: ThreadPlan,
    job: impl Fn(usize, &AtomicBool) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let ended = Mutex::new(Vec::new());
    let note = |index: usize, result: Result<T>| {
        let is_error = result.is_err();
        ended.lock().expect(NO_PANIC).push((index, result));
        // The flag is set only after the error is in the list. So the errors of jobs that stop because of the flag come
        // later in the list.
        failed.fetch_or(is_error, Ordering::Release);
    };
    let work = || {
        let pool = match pool(NonZeroUsize::new(plan.threads)) {
            Ok(pool) => pool,
            Err(error) => return note(0, Err(error)),
        };
        while !failed.load(Ordering::Acquire) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= jobs {
                break;
            }
            note(index, pool.install(|| job(index, &failed)));
        }
    };
    thread::scope(|scope| {
        for _ in 0..plan.at_work.min(jobs) {
            scope.spawn(work);
        }
    });
    let ended = ended.into_inner().expect(NO_PANIC).into_iter();
    let mut done: Vec<(usize, T)> = ended
        .map(|(index, result)| Ok((index, result?)))
        .collect::<Result<_>>()?;
    done.sort_unstable_by_key(|(index, _)| *index);
    Ok(done.into_iter().map(|(_, of_job)| of_job).collect())
}
