use cosmic::error::Error;
use cosmic::parallel::{ThreadPlan, in_parallel};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn every_job_is_done_once_and_in_order() {
    for threads in [1, 3, 64] {
        let counts = [(); 17].map(|()| AtomicUsize::new(0));
        let plan = ThreadPlan::of_one(NonZeroUsize::new(threads));
        let done = in_parallel(17, plan, |job, _| {
            counts[job].fetch_add(1, Ordering::Relaxed);
            Ok(job * job)
        });
        assert!(counts.iter().all(|n| n.load(Ordering::Relaxed) == 1));
        assert!(done.unwrap().into_iter().eq((0..17).map(|job| job * job)));
    }
}

#[test]
fn threads_are_divided_among_jobs() {
    for (threads, jobs, [at_work, each]) in [
        (8, 3, [3, 2]),
        (2, 5, [2, 1]),
        (4, 1, [1, 4]),
        (1, 9, [1, 1]),
        (3, 0, [1, 3]),
    ] {
        let plan = ThreadPlan::shared_out(threads, jobs);
        assert_eq!([plan.at_work, plan.threads], [at_work, each]);
        let found = in_parallel(jobs, plan, |_, _| Ok(rayon::current_num_threads()));
        assert_eq!(found.unwrap(), vec![each; jobs]);
    }
}

#[test]
fn no_job_begins_after_an_error() {
    let begun = AtomicUsize::new(0);
    let plan = ThreadPlan::of_one(NonZeroUsize::new(2));
    let error = in_parallel(100, plan, |job, _| {
        begun.fetch_add(1, Ordering::Relaxed);
        match job {
            3 => Err(Error::Usage("the third".to_owned())),
            _ => Ok(()),
        }
    });
    assert_eq!(error.unwrap_err().to_string(), "the third");
    // When the error occurs, the other thread may be working on any job. It begins no other job.
    assert!((4..=100).contains(&begun.load(Ordering::Relaxed)));
}

/// A job stops when it sees that another job has failed. The returned error is the error of the job that failed
/// first.
#[test]
fn jobs_can_see_an_error_of_others() {
    let plan = ThreadPlan::of_one(NonZeroUsize::new(2));
    let error = in_parallel(2, plan, |job, failed| {
        if job == 1 {
            return Err::<(), _>(Error::Usage("the cause".to_owned()));
        }
        while !failed.load(Ordering::Acquire) {
            std::thread::yield_now();
        }
        Err(Error::Usage("stopped because of it".to_owned()))
    });
    assert_eq!(error.unwrap_err().to_string(), "the cause");
}
