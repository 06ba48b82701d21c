//! A run's folder as its report needs it.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::codesign::Record;
use crate::design::Material;
use crate::error::{Error, Result};
use crate::lattice::{Ground, Lattice, State};
use crate::record::files::{self, Format};
use crate::scene::Scene;
use crate::simulator::Trajectory;

/// What a finished run left behind, read and found to fit together.
#[derive(Debug)]
pub struct Run {
    /// Its folder.
    pub folder: PathBuf,
    /// The complete scene.
    pub scene: Scene,
    /// The scene's lattice.
    pub lattice: Lattice,
    /// The delivered design, one entry per edge of the lattice.
    pub design: Design,
    /// What was reached.
    pub summary: Summary,
    /// The iterations from first to last.
    pub history: Vec<Record>,
    /// The delivered design's rollout; at least one state.
    pub trajectory: Trajectory<f64>,
}

/// The part of `design.json` that can be drawn.
#[derive(Clone, Debug, Deserialize)]
pub struct Design {
    /// Nodes that every edge joins.
    pub edges: Vec<[usize; 2]>,
    /// Design vector per edge.
    pub z: Vec<[f64; 3]>,
    /// Material per edge.
    pub materials: Vec<Material>,
}

/// The part of `summary.json` that reports show. Lengths in metres.
#[derive(Clone, Debug, Deserialize)]
pub struct Summary {
    /// Displacement of the payload in one unperturbed rollout, x and y of the world.
    pub displacement: [f64; 2],
    /// The same along the ground.
    pub displacement_along: f64,
    /// 10 % quantile over perturbed starts.
    pub displacement_p10: f64,
    /// Median over perturbed starts: the figure to quote.
    pub displacement_p50: f64,
    /// 90 % quantile over perturbed starts.
    pub displacement_p90: f64,
    /// Median of the last iterate over the same starts.
    pub displacement_last_p50: f64,
    /// Share of solid edges.
    #[serde(rename = "V")]
    pub volume: f64,
    /// Share of actuators.
    #[serde(rename = "V_act")]
    pub actuator_volume: f64,
    /// Seed of the random generator.
    pub seed: u64,
    /// How long the optimisation took.
    pub seconds: f64,
}

/// `trajectory.json`.
#[derive(Deserialize)]
struct States {
    steps: Vec<usize>,
    states: Vec<Positions>,
}

/// Positions and velocities of the nodes.
#[derive(Deserialize)]
struct Positions {
    x: Vec<[f64; 2]>,
    v: Vec<[f64; 2]>,
}

const DESIGN: Format = Format {
    name: "cosmic-design",
    version: 1,
};
const SUMMARY: Format = Format {
    name: "cosmic-summary",
    version: 1,
};
const TRAJECTORY: Format = Format {
    name: "cosmic-trajectory",
    version: 1,
};

impl Run {
    /// Reads a finished run.
    ///
    /// # Errors
    /// [`Error::Read`] where a file is missing, [`Error::Malformed`] where one is cut off or not
    /// what it should be, [`Error::Misfit`] where two do not belong together.
    pub fn read(folder: &Path) -> Result<Self> {
        let scene = Scene::read(&folder.join("scene.toml"))?;
        let lattice = Lattice::new(&scene.lattice, &Ground::from(&scene.physics));
        Ok(Self {
            summary: read_summary(folder)?,
            design: read_design(folder, &lattice)?,
            history: read_history(&folder.join("history.jsonl"))?,
            trajectory: read_trajectory(folder, &lattice)?,
            folder: folder.to_owned(),
            scene,
            lattice,
        })
    }

    /// What a reader calls the run: its folder's name.
    pub fn name(&self) -> String {
        name(&self.folder)
    }
}

/// The last part of a path, or all of a path that has none.
pub(super) fn name(folder: &Path) -> String {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let last = path.file_name().unwrap_or(path.as_os_str());
    last.to_string_lossy().into_owned()
}

/// Reads `summary.json` of a run's folder.
///
/// # Errors
/// As [`Run::read`].
pub fn read_summary(folder: &Path) -> Result<Summary> {
    files::read_json(&folder.join("summary.json"), SUMMARY)
}

fn read_design(folder: &Path, lattice: &Lattice) -> Result<Design> {
    let file = folder.join("design.json");
    let design: Design = files::read_json(&file, DESIGN)?;
    let edges = lattice.edges.len();
    fits(&file, "edges", [design.edges.len(), edges])?;
    fits(&file, "design vectors", [design.z.len(), edges])?;
    fits(&file, "materials", [design.materials.len(), edges])?;
    let same = design.edges.iter().zip(&lattice.edges);
    let shared = same.take_while(|(found, expected)| found == expected);
    fits(
        &file,
        "leading edges that are the lattice's",
        [shared.count(), edges],
    )?;
    Ok(design)
}

fn read_trajectory(folder: &Path, lattice: &Lattice) -> Result<Trajectory<f64>> {
    let file = folder.join("trajectory.json");
    let States { steps, states } = files::read_json(&file, TRAJECTORY)?;
    fits(&file, "states", [states.len(), steps.len().max(1)])?;
    for Positions { x, v } in &states {
        fits(&file, "positions of a state", [x.len(), lattice.nodes()])?;
        fits(&file, "velocities of a state", [v.len(), lattice.nodes()])?;
    }
    let states = states.into_iter().map(|Positions { x, v }| State { x, v });
    Ok(Trajectory {
        steps,
        states: states.collect(),
    })
}

fn read_history(file: &Path) -> Result<Vec<Record>> {
    let text = fs::read_to_string(file).map_err(|source| Error::Read {
        path: file.into(),
        source,
    })?;
    let lines = text.lines().enumerate();
    lines
        .map(|(number, line)| parse(line, (file, number + 1)))
        .collect()
}

/// One line of a file of JSON lines.
fn parse<T: DeserializeOwned>(text: &str, (file, line): (&Path, usize)) -> Result<T> {
    serde_json::from_str(text)
        .map_err(|error| files::malformed(file, (line, error.column()), &error.to_string()))
}

/// Whether a count is the expected one.
fn fits(file: &Path, what: &str, [found, expected]: [usize; 2]) -> Result<()> {
    if found == expected {
        return Ok(());
    }
    Err(Error::Misfit {
        file: file.display().to_string(),
        what: what.to_owned(),
        expected,
        found,
    })
}
