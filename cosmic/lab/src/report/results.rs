//! A run's folder as its report needs it.

use std::path::{Path, PathBuf};

use cosmic::codesign::Record;
use cosmic::error::{Error, Result, fits};
use cosmic::ground::Ground;
use cosmic::lattice::Lattice;
use cosmic::record::files::read_json;
use cosmic::record::history::{self, DesignRow};
use cosmic::record::{DesignFile, Summary, TrajectoryFile, check_one_run, run, trajectory_file};
use cosmic::scene::Scene;

/// What a finished run left behind, read and found to fit together.
pub struct Results {
    /// The run's folder.
    pub folder: PathBuf,
    /// The complete scene.
    pub scene: Scene,
    /// The scene's lattice.
    pub lattice: Lattice,
    /// The delivered design, one entry per edge of the lattice.
    pub design: DesignFile,
    /// What was reached.
    pub summary: Summary,
    /// The iterations from first to last.
    pub history: Vec<Record>,
    /// The designs that were kept on the way; none in a run of before they were.
    pub designs: Vec<DesignRow>,
    /// The delivered design's rollout; at least one state.
    pub trajectory: TrajectoryFile,
}

impl Results {
    /// Reads a finished run.
    ///
    /// # Errors
    /// Those of [`Summary::read`]; [`Error::Read`] where another file is missing,
    /// [`Error::Malformed`] where one is cut off or not what it should be, [`Error::Misfit`] or
    /// [`Error::Usage`] where two do not belong together.
    pub fn read(folder: &Path) -> Result<Self> {
        // Written last: without it there is nothing to report on yet.
        let summary = Summary::read(folder)?;
        let scene = Scene::read(&folder.join(run::SCENE))?;
        let lattice = Lattice::new(&scene.lattice, &Ground::from(&scene.physics));
        let path = folder.join(run::DESIGN);
        let design = DesignFile::read(&path)?;
        design.robot(&scene, &path.display().to_string())?;
        let trajectory = read_trajectory(folder, (&scene, &lattice))?;
        check_one_run(folder, &scene, &design, &summary, &trajectory)?;
        Ok(Self {
            history: read_history(folder, &summary)?,
            designs: read_designs(&folder.join(history::DESIGNS), &lattice)?,
            trajectory,
            folder: folder.to_owned(),
            scene,
            lattice,
            design,
            summary,
        })
    }

    /// What a reader calls the run.
    pub fn title(&self) -> String {
        format!("{}, seed {}", self.summary.scene, self.summary.seed)
    }
}

/// A row for every iteration.
fn read_history(folder: &Path, summary: &Summary) -> Result<Vec<Record>> {
    let history = history::read(folder)?;
    let numbers = history.iter().map(|record| record.iteration);
    let entered = summary.entered.unwrap_or(0);
    let (first, last) = (
        entered.saturating_add(1),
        entered.saturating_add(summary.iterations),
    );
    match numbers.eq(first..=last) {
        true => Ok(history),
        false => Err(Error::Usage(format!(
            "{}: its rows are not those of the iterations {first} to {last}, one after the other",
            folder.join(history::LINES).display()
        ))),
    }
}

fn read_trajectory(folder: &Path, (scene, lattice): (&Scene, &Lattice)) -> Result<TrajectoryFile> {
    let path = &folder.join(trajectory_file::TRAJECTORY);
    let file: TrajectoryFile = read_json(path, trajectory_file::FORMAT)?;
    let name = &path.display().to_string();
    let fits = |what: &str, found, expected| fits(name, what, found, expected);
    fits(
        "`states`",
        file.states.len(),
        file.steps.len().max(1),
    )?;
    if !file.steps.is_sorted_by(|a, b| a < b) || file.dt != scene.physics.dt {
        let (path, dt) = (path.display(), scene.physics.dt);
        return Err(Error::Usage(format!(
            "{path}: `steps` must ascend, and `dt` be the scene's, {dt} s"
        )));
    }
    for state in &file.states {
        fits("positions of a state", state.x.len(), lattice.nodes())?;
    }
    Ok(file)
}

/// The designs on the way, each with an entry per edge.
fn read_designs(path: &Path, lattice: &Lattice) -> Result<Vec<DesignRow>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let rows: Vec<DesignRow> = history::read_lines(path, history::DESIGNS_FORMAT)?;
    match rows.iter().find(|row| row.z.len() != lattice.edges.len()) {
        None => Ok(rows),
        Some(row) => Err(Error::Misfit {
            file: path.display().to_string(),
            what: format!("entries in `z` of iteration {}", row.iteration),
            expected: lattice.edges.len(),
            found: row.z.len(),
        }),
    }
}
