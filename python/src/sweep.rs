//! Does the runs of sweeps one at a time, and merges the results.

use crate::errors::unlocked;
use crate::loss::Failure;
use crate::optimise::{Listener, Watch, attended_run};
use crate::scene::Scene;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic_lab::sweep::{self, Overrides, Plan, RunOutcome, Sweep};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::num::NonZeroUsize;
use std::path::PathBuf;

fn planned(spec: String) -> Result<Plan> {
    sweep::read(&[spec], &Overrides::default(), &Registry::default())
}

/// The number of runs of a sweep. `spec` is a sweep's file or a scene.
#[pyfunction]
pub(crate) fn sweep_count(py: Python, spec: String) -> PyResult<usize> {
    unlocked(py, || Ok(planned(spec)?.runs()))
}

/// Does or continues one run of a sweep on one thread. Returns its outcome as one word. `check` gets the scene before any
/// work is done, and may raise an exception.
#[pyfunction]
pub(crate) fn sweep_run(
    py: Python,
    spec: String,
    folder: PathBuf,
    index: usize,
    check: Bound<PyAny>,
) -> PyResult<&'static str> {
    let registry = Registry::default();
    let read = || {
        let plan = planned(spec)?;
        let run = plan.run(index, &registry)?;
        Ok((plan, run))
    };
    let (plan, run) = unlocked(py, read)?;
    let (scene, name) = (run.scene, run.name);
    check.call1((Scene { scene, name },))?;
    let one = Some(NonZeroUsize::MIN);
    let work = |watch: &mut Watch| -> Result<_> {
        plan.keep(&folder, &registry)?;
        let sweep = Sweep {
            folder: &folder,
            plan: &plan,
            registry: &registry,
        };
        Ok(match sweep.run_one(index, watch)? {
            RunOutcome::Done(_) => "done",
            RunOutcome::Diverged(_) => "diverged",
            RunOutcome::Over => "over",
            RunOutcome::Taken => "taken",
        })
    };
    let ended = attended_run(py, one, &Failure::default(), &Listener::default(), work)?;
    ended.ok_or_else(|| PyKeyboardInterrupt::new_err(()))
}

/// Merges the finished runs. Returns the path of the results.
#[pyfunction]
pub(crate) fn sweep_merge(py: Python, folder: PathBuf) -> PyResult<PathBuf> {
    unlocked(py, || Ok(sweep::merge(&folder)?.results))
}
