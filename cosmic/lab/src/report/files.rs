//! Reads the files of a run, or of a design alone, for reports.

use cosmic::Registry;
use cosmic::case::Case;
use cosmic::design::{Design, Material, Mixture};
use cosmic::error::{Error, Result, fits};
use cosmic::judge::verdict::Verdict;
use cosmic::lattice::Lattice;
use cosmic::outcome::{DesignFile, Summary};
use cosmic::policy::frequency;
use cosmic::projection::{Projection, Projector};
use cosmic::reading::read_whole;
use cosmic::record::damaged::explained;
use cosmic::record::files::read_json;
use cosmic::record::history::{self, DesignRow};
use cosmic::record::summary::result_of;
use cosmic::record::{TrajectoryFile, run, trajectory_file};
use cosmic::scene::Scene;
use cosmic::search::Record;
use std::path::{Path, PathBuf};

/// A design and its scene.
pub struct RobotFiles {
    /// The complete scene.
    pub scene: Scene,
    /// The scene's lattice.
    pub lattice: Lattice,
    /// The design, one entry per edge of the lattice.
    pub design: DesignFile,
    /// The angular frequency of the clock, rad/s.
    pub omega: f64,
}

impl RobotFiles {
    /// Reads a design and the scene beside it.
    ///
    /// # Errors
    /// [`Error::Read`] if a file is missing, [`Error::Malformed`] if a file is malformed, [`Error::Misfit`] or
    /// [`Error::Usage`] if the two files do not belong together.
    pub fn read(path: &Path, registry: &Registry) -> Result<Self> {
        // The design is read first: if the file is not a design, its scene does not matter.
        let design = DesignFile::read(path).map_err(explained(path))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let scene = run::read_scene(folder, registry)?;
        let file = path.display().to_string();
        let design = design.in_order(&scene, &file)?;
        let controller = design.robot(&scene, &file)?;
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        Ok(Self {
            omega: frequency(&scene.controller, &controller),
            scene,
            lattice,
            design,
        })
    }

    /// Makes a case, which can be simulated. `path` is the file of the design, for messages.
    ///
    /// # Errors
    /// The errors of [`DesignFile::case`].
    pub fn case(&self, path: &Path) -> Result<Case> {
        self.design.case(&self.scene, &path.display().to_string())
    }

    /// Returns the indices of the edges whose material in the final design satisfies `kind`.
    pub fn edges_of(&self, kind: fn(Material) -> bool) -> Vec<usize> {
        let materials = self.design.materials.iter().enumerate();
        let of_kind = materials.filter(|(_, material)| kind(**material));
        of_kind.map(|(edge, _)| edge).collect()
    }

    /// Returns a copy of the robot for drawing. Each edge has the solid material of which it has more, or void if it has
    /// almost no solid material.
    pub(super) fn drawn(&self) -> Self {
        let drawn = |mixture: Mixture<f64>| {
            if mixture[Material::Void] > 0.98 {
                Material::Void
            } else if mixture[Material::Skeleton] >= mixture[Material::Actuator] {
                Material::Skeleton
            } else {
                Material::Actuator
            }
        };
        let mut design = self.design.clone();
        design.materials = (self.mixtures(&design.z).into_iter()).map(drawn).collect();
        Self {
            scene: self.scene.clone(),
            lattice: self.lattice.clone(),
            design,
            omega: self.omega,
        }
    }

    /// Returns the mixture of each edge for the design vectors `z`. One-hot vectors, which are the form of a layout,
    /// are allowed too.
    pub(super) fn mixtures(&self, z: &[[f64; 3]]) -> Vec<Mixture<f64>> {
        let projector = Projector::new(&self.scene.projection, &self.lattice);
        let design = Design::of_vectors(z.to_vec());
        let design = projector.projected(Projection::Performance, &design);
        design.mixtures().into_owned()
    }
}

/// The files of a finished run.
pub struct RunFiles {
    /// The run's folder.
    pub folder: PathBuf,
    /// The final design of the run, and its scene.
    pub robot: RobotFiles,
    /// The summary of the run.
    pub summary: Summary,
    /// The records of the iterations from first to last; empty if no history was kept.
    pub history: Vec<Record>,
    /// The designs recorded during the optimisation; empty if they were not kept.
    pub designs: Vec<DesignRow>,
    /// The rollout of the final design. It has at least one state.
    pub trajectory: TrajectoryFile,
}

impl RunFiles {
    /// Reads a finished run.
    ///
    /// # Errors
    /// The errors of [`run::read_summary`] and [`RobotFiles::read`], and similar errors for the other files.
    pub fn read(folder: &Path, registry: &Registry) -> Result<Self> {
        // The summary is written last: without it the run is not finished.
        let summary = run::read_summary(folder)?;
        let robot = RobotFiles::read(&folder.join(run::DESIGN), registry)?;
        let trajectory = read_trajectory(folder, &robot)?;
        Ok(Self {
            history: read_history(folder, &summary)?,
            designs: read_designs(&folder.join(history::DESIGNS), &robot.lattice)?,
            trajectory,
            folder: folder.to_owned(),
            robot,
            summary,
        })
    }

    /// Returns the verdict on the run's robot.
    pub fn verdict(&self) -> Verdict {
        let RobotFiles { scene, lattice, .. } = &self.robot;
        self.summary.measured(scene, lattice).verdict()
    }

    /// Returns the title of the run in documents.
    pub(super) fn title(&self) -> String {
        format!("{}, seed {}", self.summary.scene, self.summary.seed)
    }
}

/// Reads the history of a run: a record for every iteration. The history may have been cut off, for example by a full disk
/// or a copy that was interrupted: then it has fewer records, or none.
fn read_history(folder: &Path, summary: &Summary) -> Result<Vec<Record>> {
    let path = folder.join(history::LINES);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let history = history::read(folder, whole_lines(&path)?).map_err(explained(&path))?;
    let numbers = history.iter().map(|record| record.iteration);
    let entered = summary.entered.unwrap_or(0);
    let first = entered.saturating_add(1);
    let last = entered.saturating_add(summary.iterations);
    if history.len() <= summary.iterations && numbers.eq((first..=last).take(history.len())) {
        return Ok(history);
    }
    Err(Error::Usage(format!(
        "{}: expected one row for each of the iterations {first} to {last}, in this order",
        path.display()
    )))
}

/// The number of lines of a file that are not cut off. Zero bytes at the end, which a crash of the machine leaves, count as a
/// line, so that they are reported when it is read.
fn whole_lines(path: &Path) -> Result<usize> {
    let bytes = read_whole(path)?;
    let mut lines = bytes.split(|&byte| byte == b'\n');
    let is_damaged = lines.next_back().is_some_and(|last| last.contains(&0));
    Ok(lines.count() + usize::from(is_damaged))
}

pub(super) fn read_trajectory(folder: &Path, robot: &RobotFiles) -> Result<TrajectoryFile> {
    let path = &result_of(folder, trajectory_file::TRAJECTORY)?;
    let file: TrajectoryFile = read_json(path, trajectory_file::FORMAT).map_err(explained(path))?;
    let name = &path.display().to_string();
    let fits = |what: &str, found, expected| fits(name, what, found, expected);
    let states = file.steps.len().max(1);
    fits("`states`", file.states.len(), states)?;
    if !file.bars.is_empty() {
        fits(
            "entries in `bars`",
            file.bars.len(),
            robot.lattice.edges.len(),
        )?;
    }
    let (dt, steps) = (robot.scene.physics.dt, robot.scene.physics.steps);
    let last = file.steps.last().copied().unwrap_or(0);
    if !file.steps.is_sorted_by(|a, b| a < b) || file.dt != dt {
        let wrong = format!("{name}: `steps` must ascend, and `dt` must be {dt} s as in the scene");
        return Err(Error::Usage(wrong));
    }
    if last != steps {
        return Err(Error::Usage(format!(
            "{name}: expected {steps}, the scene's number of steps, as the last of `steps`; found {last}"
        )));
    }
    for state in &file.states {
        fits("positions of a state", state.x.len(), robot.lattice.nodes())?;
    }
    Ok(file)
}

/// Reads the designs recorded during the optimisation. Returns an error if a design does not have one entry per edge.
fn read_designs(path: &Path, lattice: &Lattice) -> Result<Vec<DesignRow>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let rows: Vec<DesignRow> =
        history::read_lines(path, history::DESIGNS_FORMAT, whole_lines(path)?)
            .map_err(explained(path))?;
    let name = &path.display().to_string();
    for row in &rows {
        let what = format!("entries in `z` of iteration {}", row.iteration);
        fits(name, &what, row.z.len(), lattice.edges.len())?;
    }
    Ok(rows)
}
