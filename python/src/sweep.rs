//! Does the runs of sweeps one at a time, and merges the results.

use crate::attended::{Listener, Watch, attended};
use crate::errors::{caught, raised};
use crate::loss::Failure;
use crate::memory::optimisation_fits;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic_lab::sweep::{self, Overrides, Plan, RunOutcome, Sweep};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::path::PathBuf;

fn planned(py: Python, spec: String) -> PyResult<Plan> {
    let read = || sweep::read(&[spec], &Overrides::default(), &Registry::default());
    py.detach(read).map_err(raised)
}

/// The number of runs of a sweep. `spec` is a sweep's file or a scene.
#[pyfunction]
pub(crate) fn sweep_count(py: Python, spec: String) -> PyResult<usize> {
    caught(|| Ok(planned(py, spec)?.runs()))
}

/// Does or continues one run of a sweep on one thread. Returns its outcome as one word.
#[pyfunction]
pub(crate) fn sweep_run(
    py: Python,
    spec: String,
    folder: PathBuf,
    index: usize,
) -> PyResult<&'static str> {
    let (plan, registry) = (caught(|| planned(py, spec))?, Registry::default());
    let run = plan.run(index, &registry).map_err(raised)?;
    optimisation_fits(&run.scene)?;
    let (failure, listener) = (Failure::default(), Listener::default());
    let work = move |watch: &mut Watch| -> Result<_> {
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
    let ended = attended(py, 1, &failure, &listener, Default::default(), work)?;
    ended.ok_or_else(|| PyKeyboardInterrupt::new_err(()))
}

/// Merges the finished runs. Returns the path of the results.
#[pyfunction]
pub(crate) fn sweep_merge(py: Python, folder: PathBuf) -> PyResult<PathBuf> {
    let merged = caught(|| {
        py.detach(|| sweep::merge(&folder, &Registry::default()))
            .map_err(raised)
    })?;
    Ok(merged.results)
}
