//! Reads finished runs, and makes their pages.

use crate::errors::unlocked;
use cosmic::Registry;
use cosmic_lab::report::RunFiles;
use pyo3::prelude::*;
use std::path::PathBuf;

/// Reads a finished run. Returns the text of its design, with the edges in the order of the
/// lattice, and the positions of the nodes at rest.
#[pyfunction]
pub(crate) fn load(py: Python, folder: PathBuf) -> PyResult<(String, Vec<Vec<f64>>)> {
    unlocked(py, || {
        let robot = RunFiles::read(&folder, &Registry::default())?.robot;
        let (dimension, positions) = (robot.lattice.dimension, robot.lattice.positions.iter());
        let rest = positions.map(|&position| dimension.list(position));
        Ok((robot.design.to_json(), rest.collect()))
    })
}

/// Writes the report of a run.
#[pyfunction]
pub(crate) fn report(py: Python, folder: PathBuf) -> PyResult<()> {
    unlocked(py, || {
        cosmic_lab::report::write(&folder, &Registry::default()).map(drop)
    })
}

/// Returns a page with the moving robot of a run.
#[pyfunction]
pub(crate) fn player_page(py: Python, folder: PathBuf) -> PyResult<String> {
    unlocked(py, || {
        let run = RunFiles::read(&folder, &Registry::default())?;
        Ok(cosmic_lab::report::player_page(&run))
    })
}
