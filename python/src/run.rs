//! Reads finished runs, and makes their pages and pictures.

use crate::arrays::{Given, array, array_of, joined};
use crate::errors::{OutOfMemoryError, caught, raised, refused};
use cosmic::Registry;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Vector, flat, from_flat};
use cosmic::lattice::{Lattice, State};
use cosmic::policy::{Controller, NETWORK, TEMPO, frequency};
use cosmic::record::history::LINES;
use cosmic::record::run::SCENE;
use cosmic::record::summary::SUMMARY;
use cosmic::record::{DesignFile, TrajectoryFile};
use cosmic_lab::report::{FRAME_WIDTH, RobotFiles, RunFiles};
use numpy::PyArray3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::fs;
use std::path::{Path, PathBuf};

/// Returns the text of a file, or an empty text if the file does not exist.
fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_default()
}

/// Reads a finished run. Returns a dictionary of its arrays and of the texts of its files.
#[pyfunction]
pub(crate) fn load<'py>(py: Python<'py>, folder: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    let run = caught(|| {
        py.detach(|| RunFiles::read(&folder, &Registry::default()))
            .map_err(raised)
    })?;
    let (design, trajectory) = (&run.robot.design, &run.trajectory);
    let weights = &design.controller;
    let (edges, nodes) = (design.edges.len(), run.robot.lattice.nodes());
    let floats = |numbers: &[f64], shape: &[usize]| array(py, numbers.to_vec(), shape);
    let states = trajectory.states.len();
    let coordinates = |of: fn(&State<f64>) -> &[Vector<f64>]| -> Vec<f64> {
        trajectory
            .states
            .iter()
            .flat_map(|state| flat(of(state)))
            .collect()
    };
    let whole = |numbers: Vec<i64>, shape: &[usize]| array(py, numbers, shape);
    let ends = design.edges.as_flattened().iter().map(|&node| node as i64);
    let materials = design.materials.iter().map(|&material| material as i64);
    let steps = trajectory.steps.iter().map(|&step| step as i64);
    let rest = &run.robot.lattice.positions;
    let read = PyDict::new(py);
    read.set_item("edges", whole(ends.collect(), &[edges, 2])?)?;
    read.set_item("materials", whole(materials.collect(), &[edges])?)?;
    read.set_item("z", floats(design.z.as_flattened(), &[edges, 3])?)?;
    for (place, name) in NETWORK.into_iter().enumerate() {
        let is_part = |name: &str| array_of(name) == Some(place);
        let own = weights.blocks().filter(|(name, ..)| is_part(name));
        let (axes, numbers): (Vec<_>, Vec<_>) =
            own.map(|(_, axes, numbers)| (axes, numbers)).unzip();
        let axes = joined(axes.into_iter());
        read.set_item(name, floats(&numbers.concat(), &axes)?)?;
    }
    if let Some((_, axes, numbers)) = weights.blocks().find(|(name, ..)| *name == TEMPO) {
        read.set_item(TEMPO, floats(&numbers, &axes)?)?;
    }
    read.set_item("rest", floats(&flat(rest), &[nodes, 2])?)?;
    read.set_item("steps", whole(steps.collect(), &[states])?)?;
    read.set_item(
        "x",
        floats(&coordinates(|state| &state.x), &[states, nodes, 2])?,
    )?;
    read.set_item(
        "v",
        floats(&coordinates(|state| &state.v), &[states, nodes, 2])?,
    )?;
    read.set_item("dt", trajectory.dt)?;
    read.set_item("omega", run.robot.omega)?;
    read.set_item("summary", text(&folder.join(SUMMARY)))?;
    read.set_item("history", text(&folder.join(LINES)))?;
    read.set_item("scene", text(&folder.join(SCENE)))?;
    Ok(read)
}

/// Writes the report of a run, and returns the paths of its files.
#[pyfunction]
pub(crate) fn report(py: Python, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
    let write = || cosmic_lab::report::write(&folder, &Registry::default());
    caught(|| py.detach(write).map_err(raised))
}

/// Returns a page with the moving robot of a run.
#[pyfunction]
pub(crate) fn player_page(py: Python, folder: PathBuf) -> PyResult<String> {
    let page = || {
        Ok(cosmic_lab::report::player_page(&RunFiles::read(
            &folder,
            &Registry::default(),
        )?))
    };
    caught(|| py.detach(page).map_err(raised))
}

/// Draws a robot in the last of the states `x`. Returns the picture, an array of shape `(rows, columns, 3)`.
#[pyfunction]
pub(crate) fn frame<'py>(
    py: Python<'py>,
    scene: &crate::scene::Scene,
    z: &Bound<'py, PyAny>,
    steps: Vec<usize>,
    x: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let scene = &scene.scene;
    let lattice = Lattice::new(&scene.lattice, &scene.physics);
    let (edges, nodes) = (lattice.edges.len(), lattice.nodes());
    let [z, x] = [Given::<f64>::new("z", z)?, Given::<f64>::new("x", x)?];
    let states = x.batch(&[nodes, 2])?;
    if z.shape() != [edges, 3] || states.is_none_or(|count| count != steps.len()) {
        return Err(refused(format!(
            "expected z of the shape ({edges}, 3) and x of the shape ({}, {nodes}, 2)",
            steps.len()
        )));
    }
    let z: &[[f64; 3]] = z.finite()?.as_chunks().0;
    let materials: Vec<_> = z.iter().map(Material::dominant).collect();
    let controller = Controller::xavier(&scene.controller, &lattice, 0);
    let layout = Design::Layout(materials.clone());
    let design = DesignFile::new(&lattice, &layout, &materials, &controller);
    let state = |x: &[f64]| {
        let x = from_flat(x);
        State {
            v: vec![Vector::zero(); x.len()],
            x,
        }
    };
    let trajectory = TrajectoryFile {
        dt: scene.physics.dt,
        steps,
        states: x.finite()?.chunks_exact(2 * nodes).map(state).collect(),
        bars: Vec::new(),
    };
    let robot = RobotFiles {
        scene: scene.clone(),
        foreign: None,
        lattice,
        design,
        omega: frequency(&scene.controller, &controller),
    };
    let last = trajectory.states.len() - 1;
    let draw = || cosmic_lab::report::frame(&robot, &trajectory, last);
    let drawn = caught(|| Ok(py.detach(draw)))?;
    let drawn = drawn
        .ok_or_else(|| OutOfMemoryError::new_err("there is not enough memory for the picture"))?;
    let rows = drawn.len() / 3 / FRAME_WIDTH;
    let drawn = array(py, drawn, &[rows, FRAME_WIDTH, 3])?;
    Ok(drawn.cast_into()?)
}
