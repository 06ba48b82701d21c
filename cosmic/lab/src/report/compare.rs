//! Compares several runs side by side: their numbers, and their robots in motion.

use super::files::{RobotFiles, read_trajectory};
use super::motion::Motion;
use super::numbers::{departures, with_numbers};
use super::{data, page};
use crate::table::{Table, TableOf};
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::record::Summary;
use cosmic::record::run::{DESIGN, SCENE, read_scene_to_show};
use cosmic::record::trajectory_file::TRAJECTORY;
use serde::Serialize;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The summaries of several runs.
#[derive(Debug, Serialize)]
pub struct Comparison {
    runs: Vec<ComparedRun>,
}

/// One run of a comparison.
#[derive(Debug, Serialize)]
struct ComparedRun {
    /// The name of the run's folder. If the folder of another run has the same name, the whole path.
    #[serde(rename = "run")]
    name: String,
    summary: Summary,
    #[serde(skip)]
    folder: PathBuf,
}

impl ComparedRun {
    /// Returns the data from which the page draws one run: the robot and its motion.
    fn lane(&self, registry: &Registry) -> Result<Value> {
        let robot = RobotFiles::read(&self.folder.join(DESIGN), registry)?;
        let trajectory = read_trajectory(&self.folder, &robot)?;
        let is_unreliable = self.summary.is_unreliable();
        let mark = if is_unreliable { " (unreliable)" } else { "" };
        let name = format!("{}{mark}", self.name);
        Ok(data::of_lane(&name, &Motion::new(&robot, &trajectory)))
    }
}

/// Reads the summary of a run. Fails if the scene file in its folder has another scene than the one that the run began
/// with.
fn read(folder: &Path, registry: &Registry) -> Result<Summary> {
    let summary = Summary::read(folder)?;
    if folder.join(SCENE).exists() {
        read_scene_to_show(folder, registry)?;
    }
    Ok(summary)
}

impl Comparison {
    /// Reads the summaries of runs.
    ///
    /// # Errors
    /// The errors of [`Summary::read`] and [`read_scene_to_show`].
    pub fn read(folders: &[PathBuf], registry: &Registry) -> Result<Self> {
        let names: Vec<String> = folders.iter().map(|folder| name(folder)).collect();
        let run = |(folder, name): (&PathBuf, &String)| {
            let mut others = folders.iter().zip(&names);
            let has_namesake = others.any(|(other, of)| of == name && other != folder);
            let path = || folder.display().to_string();
            Ok(ComparedRun {
                name: if has_namesake { path() } else { name.clone() },
                summary: read(folder, registry)?,
                folder: folder.clone(),
            })
        };
        let runs = folders.iter().zip(&names).map(run).collect::<Result<_>>()?;
        Ok(Self { runs })
    }

    /// Starts the table with a row for each run and the columns that every comparison has. The caller may add columns
    /// before it finishes the table.
    fn columns(&self) -> TableOf<'_, ComparedRun> {
        let names = Table::of("", "", &self.runs).column("run", "", |run| &run.name[..]);
        with_numbers(names, |run| &run.summary)
    }

    /// Returns the table as aligned text for a terminal.
    pub fn to_text(&self) -> String {
        self.columns().done().to_text()
    }

    /// Returns a page on which the robots walk side by side, above the table. A run without a trajectory is only in the
    /// table.
    ///
    /// # Errors
    /// The errors of reading designs, scenes and trajectories.
    pub fn to_html(&self, registry: &Registry) -> Result<String> {
        let departures = |run: &ComparedRun| departures(&run.summary);
        let table = self.columns();
        let table = table.column("departures from the paper", "", departures);
        let (title, table) = ("Runs side by side", table.done().to_html());
        let with_lane = self
            .runs
            .iter()
            .filter(|run| run.folder.join(TRAJECTORY).exists());
        let lanes: Vec<Value> = with_lane
            .map(|run| run.lane(registry))
            .collect::<Result<_>>()?;
        let race = if lanes.is_empty() {
            String::new()
        } else {
            include_str!("page/race.html").to_owned()
                + &page::script(&lanes.into(), include_str!("page/race.js"))
        };
        let body = format!(
            "<h1>{title}</h1>\n{race}<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Numbers\">{table}</div>\n"
        );
        Ok(page::html(title, &body))
    }
}

/// Returns the last part of a path, or the whole path if it has none.
fn name(folder: &Path) -> String {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let last = path.file_name().unwrap_or(path.as_os_str());
    last.to_string_lossy().into_owned()
}
