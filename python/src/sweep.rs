//! Plans sweeps, does their runs one at a time, and merges the results.

use crate::attended::{Listener, attended};
use crate::errors::{caught, raised, refused};
use crate::loss::Failure;
use crate::memory::optimisation_fits;
use crate::scene::Scene;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic_lab::sweep::{self, RunOutcome, Sweep, SweepPlan, on_grid};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Writes a plan of scenes, settings and seeds into a new folder. Each entry of `grid` has the form `KEY=V,V`.
#[pyfunction]
pub(crate) fn sweep_plan(
    py: Python,
    folder: PathBuf,
    scenes: Vec<PyRef<Scene>>,
    grid: Vec<String>,
    first_seed: u64,
    seeds: usize,
    iterations: Option<usize>,
) -> PyResult<()> {
    let count = |name: &str, number: usize| {
        NonZeroUsize::new(number).ok_or_else(|| refused(format!("{name}: expected 1 or more")))
    };
    let seeds = count("seeds", seeds)?;
    let iterations = iterations.map(|n| count("iterations", n)).transpose()?;
    let named: Vec<_> = scenes
        .iter()
        .map(|scene| (scene.name.clone(), scene.scene.clone()))
        .collect();
    for scene in &scenes {
        optimisation_fits(&scene.scene)?;
    }
    let freeze = || -> Result<()> {
        let plan = SweepPlan {
            study: None,
            first_seed,
            seeds,
            iterations,
            scenes: on_grid(&named, &[], &grid)?,
        };
        plan.freeze(&folder, &Registry::default())
    };
    caught(|| py.detach(freeze).map_err(raised))
}

/// A flag that stops runs of a sweep in other threads, in the same way as a signal stops a run in the calling thread.
#[pyclass(frozen, module = "cosmic._core")]
#[derive(Default)]
pub(crate) struct Stop(Arc<AtomicBool>);

#[pymethods]
impl Stop {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Tells the runs to save their state and end.
    fn set(&self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Does or continues one run of a sweep on one thread. Returns its outcome as one word.
#[pyfunction]
#[pyo3(signature = (folder, index, stop = None))]
pub(crate) fn sweep_run(
    py: Python,
    folder: PathBuf,
    index: usize,
    stop: Option<&Stop>,
) -> PyResult<&'static str> {
    let (failure, listener) = (Failure::default(), Listener::default());
    let stop = stop.map_or_else(Arc::default, |stop| Arc::clone(&stop.0));
    let asked = Arc::clone(&stop);
    let ended = attended(py, 1, &failure, &listener, stop, move |watch| {
        let plan = &SweepPlan::read(&folder)?;
        if index >= plan.runs() {
            let runs = plan.runs();
            return Err(Error::Usage(format!(
                "there is no run {index}: the plan has {runs} runs, numbered from 0"
            )));
        }
        let is_stopped = || asked.load(Ordering::Relaxed);
        let sweep = Sweep {
            folder: &folder,
            plan,
            registry: &Registry::default(),
        };
        Ok(match sweep.run_one(index, watch, &is_stopped)? {
            RunOutcome::Done(_) => "done",
            RunOutcome::Diverged(_) => "diverged",
            RunOutcome::Over => "over",
            RunOutcome::Taken => "taken",
        })
    })?;
    ended.ok_or_else(|| PyKeyboardInterrupt::new_err(()))
}

/// Returns the folders of all runs of a sweep, and the numbers of the unfinished runs.
#[pyfunction]
pub(crate) fn sweep_status(py: Python, folder: PathBuf) -> PyResult<(Vec<PathBuf>, Vec<usize>)> {
    let survey = || -> Result<_> {
        let plan = SweepPlan::read(&folder)?;
        let folders = (0..plan.runs())
            .map(|index| plan.folder(&folder, index))
            .collect();
        Ok((folders, sweep::survey(&folder, &plan).left()))
    };
    caught(|| py.detach(survey).map_err(raised))
}

/// Merges the finished runs. Returns the path of the table and the number of missing runs.
#[pyfunction]
pub(crate) fn sweep_merge(py: Python, folder: PathBuf) -> PyResult<(PathBuf, usize)> {
    let merge = || sweep::merge(&folder, &SweepPlan::read(&folder)?);
    let merged = caught(|| py.detach(merge).map_err(raised))?;
    let table = merged.table;
    Ok((table, merged.missing))
}
