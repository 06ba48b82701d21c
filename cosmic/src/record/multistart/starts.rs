//! The runs of the starts, each in its folder `starts/SEED`. They run in parallel, one per thread.

use crate::codesign::Record;
use crate::error::{Error, Result};
use crate::parallel::{ThreadPlan, in_parallel};
use crate::record::run::{Observer, Run, take_up};
use crate::record::snapshot::{RunPlan, SNAPSHOT};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The seeds of a plan, in order.
pub(super) fn seeds(plan: &RunPlan) -> impl Iterator<Item = u64> + use<> {
    let first = plan.seed;
    (0..plan.starts.get() as u64).map(move |k| first.wrapping_add(k))
}

/// Does `work` for every seed of a plan in parallel, one per thread, and returns the results in the order of the seeds.
/// If one start fails or is interrupted, the others are interrupted. An error that tells the user to resume names the
/// folder of the search (`folder`), not the folder of a start.
pub(super) fn side_by_side<T: Send>(
    folder: &Path,
    plan: &RunPlan,
    observer: &mut dyn Observer,
    work: impl Fn(u64, &mut dyn Observer) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let seeds: Vec<u64> = seeds(plan).collect();
    let plan = ThreadPlan::shared_out(rayon::current_num_threads(), seeds.len());
    let observer = Mutex::new(observer);
    in_parallel(seeds.len(), plan, |k, failed| {
        let observer = &observer;
        let result = work(seeds[k], &mut StartObserver { observer, failed });
        result.map_err(|mut error| {
            if let Error::Interrupted { run, .. } | Error::UnstableRun { run, .. } = &mut error {
                *run = folder.into();
            }
            error
        })
    })
}

/// The observer of one start. It passes all events to the common observer.
struct StartObserver<'a, 'o> {
    observer: &'a Mutex<&'o mut dyn Observer>,
    /// True after one of the starts has failed.
    failed: &'a AtomicBool,
}

impl<'o> StartObserver<'_, 'o> {
    fn observer(&self) -> MutexGuard<'_, &'o mut dyn Observer> {
        self.observer.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for StartObserver<'_, '_> {
    fn begin(&mut self, run: &Run) {
        self.observer().begin(run);
    }

    fn iteration(&mut self, run: &Run, record: &Record) -> ControlFlow<()> {
        if self.failed.load(Ordering::Acquire) {
            return ControlFlow::Break(());
        }
        self.observer().iteration(run, record)
    }

    fn end(&mut self, run: &Run) {
        self.observer().end(run);
    }

    fn warning(&mut self, run: &Run, text: &str) {
        let seed = run.plan().seed;
        (self.observer()).warning(run, &format!("seed {seed}: {text}"));
    }

    fn stop(&self) -> Option<Arc<AtomicBool>> {
        self.observer().stop()
    }

    fn is_stopped(&self) -> bool {
        self.failed.load(Ordering::Acquire) || self.observer().is_stopped()
    }
}

/// Opens or begins the run of one seed. Returns `None` if the run is finished.
pub(super) fn run_of(folder: &Path, seed: u64, plan: &RunPlan) -> Result<Option<Run>> {
    let own = folder_of(folder, seed);
    let of_one = RunPlan {
        iterations: plan.iterations,
        ..RunPlan::new(&plan.name, plan.scene.clone(), seed)
    };
    if !own.join(SNAPSHOT).exists() {
        return Run::create(&own, &of_one).map(Some);
    }
    let taken = take_up(&own, plan.scene.registry())?;
    if let Some((_, snapshot)) = &taken {
        snapshot.plan.check_same(&of_one, &own)?;
    }
    taken
        .map(|(lock, snapshot)| Run::open(lock, snapshot, None))
        .transpose()
}

/// The folders of the starts that have begun.
pub(in crate::record) fn begun(folder: &Path, plan: &RunPlan) -> Vec<PathBuf> {
    let folders = seeds(plan).map(|seed| folder_of(folder, seed));
    folders.filter(|own| own.join(SNAPSHOT).exists()).collect()
}

/// The folder of the start with this seed, in the folder of a search.
pub fn folder_of(folder: &Path, seed: u64) -> PathBuf {
    folder.join("starts").join(seed.to_string())
}
