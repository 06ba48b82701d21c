//! Compares several runs side by side: their numbers, and their robots in motion.

use super::files::{RobotFiles, read_trajectory};
use super::motion::DrawnMotion;
use super::verdict::line;
use super::{data, page};
use crate::table::{Cell, Column, Table, TableOf, escape};
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::judge::Reliability;
use cosmic::judge::verdict::{Item, Verdict};
use cosmic::keys::{Keyed, column};
use cosmic::lattice::Lattice;
use cosmic::numbers::fixed;
use cosmic::outcome::Summary;
use cosmic::record::run::{DESIGN, SCENE, read_scene, read_summary};
use cosmic::record::snapshot::SNAPSHOT;
use cosmic::record::trajectory_file::TRAJECTORY;
use cosmic::walk::{Energy, Loads};
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
    /// `None` if the run's folder has no scene.
    verdict: Option<Verdict>,
    /// A description of the world; `None` if the run's folder has no scene.
    #[serde(skip)]
    world: Option<String>,
    /// The duration of the walk, s; `None` if the run's folder has no scene.
    #[serde(skip)]
    seconds: Option<f64>,
    #[serde(skip)]
    folder: PathBuf,
}

impl ComparedRun {
    /// Returns the data from which the page draws one run: the robot and its motion.
    fn lane(&self, registry: &Registry) -> Result<Value> {
        let robot = RobotFiles::read(&self.folder.join(DESIGN), registry)?;
        let trajectory = read_trajectory(&self.folder, &robot)?;
        let name = match &self.summary.reliability {
            Reliability::Reliable => self.name.clone(),
            doubtful => format!("{} ({})", self.name, doubtful.word()),
        };
        Ok(data::of_lane(&name, &DrawnMotion::new(&robot, &trajectory)))
    }
}

/// Reads a run. Fails if the scene file in its folder has another scene than the one that the run began with.
fn read(folder: &Path, name: String, registry: &Registry) -> Result<ComparedRun> {
    let mut run = ComparedRun {
        name,
        summary: read_summary(folder)?,
        verdict: None,
        world: None,
        seconds: None,
        folder: folder.to_owned(),
    };
    if [SCENE, SNAPSHOT]
        .iter()
        .any(|name| folder.join(name).exists())
    {
        let scene = read_scene(folder, registry)?;
        let lattice = Lattice::new(&scene.lattice, &scene.physics);
        run.world = Some(scene.describe_world());
        let measured = run.summary.measured(&scene, &lattice);
        run.verdict = Some(measured.verdict());
        run.seconds = Some(run.summary.seconds_of_walk(measured.seconds));
    }
    Ok(run)
}

impl Comparison {
    /// Reads the summaries of runs.
    ///
    /// # Errors
    /// The errors of [`read_summary`] and [`read_scene`].
    pub fn read(folders: &[PathBuf], registry: &Registry) -> Result<Self> {
        let names: Vec<String> = folders.iter().map(|folder| name(folder)).collect();
        let run = |(folder, name): (&PathBuf, &String)| {
            let mut others = folders.iter().zip(&names);
            let has_namesake = others.any(|(other, of)| of == name && other != folder);
            let path = || folder.display().to_string();
            let name = if has_namesake { path() } else { name.clone() };
            read(folder, name, registry)
        };
        let runs = folders.iter().zip(&names).map(run).collect::<Result<_>>()?;
        Ok(Self { runs })
    }

    /// Starts a table with a row and the name of each run.
    fn names(&self) -> TableOf<'_, ComparedRun> {
        Table::of("", "", &self.runs).column("run", "", |run| &run.name[..])
    }

    /// Returns a table of six columns: the run, the objective, the speed, the mass, the energy and the bars that pass
    /// through each other. If one of the runs has a loss, the loss is the objective, and the displacement replaces the
    /// energy.
    fn short(&self) -> Table {
        let has_loss = self.runs.iter().any(|run| !run.summary.is_far());
        let far = |run: &ComparedRun| run.summary.displacement_robust_p50;
        let of_energy = |name, title| declared::<Energy>(name, title, "not known");
        let mut table = self.names();
        if has_loss {
            let mut with_loss = self.runs.iter().filter(|run| !run.summary.is_far());
            table = match with_loss.all(|run| !run.summary.ways.is_empty()) {
                true => {
                    let left = Column::new("way left", "").decimals(2, "\u{2013}");
                    table.add(left, |run| run.summary.way_left())
                }
                false => {
                    let loss = declared::<Summary>("loss_p50", "loss", "\u{2013}");
                    table.add(loss, |run| run.summary.loss_p50.flatten())
                }
            };
        }
        let distance = declared::<Summary>("displacement_robust_p50", "distance", "diverged");
        let speed = Column::new("speed", "").unit("m/s");
        table = table
            .add(distance, |run| match run.summary.reliability.word() {
                // It comes before all numbers of such a robot.
                stays if run.summary.reliability.stays_in_place() => Cell::from(stays),
                unreliable if run.summary.is_unreliable() => {
                    let far = far(run).map_or("diverged".to_owned(), |far| fixed(far, 3));
                    Cell::from(format!("{far} ({unreliable})"))
                }
                _ => far(run).into(),
            })
            .add(speed.decimals(3, "not known"), |run| {
                Some(far(run)? / run.seconds?)
            })
            .add(of_energy("mass", "mass"), |run| {
                Some(run.summary.quoted_energy()?.mass)
            });
        if !has_loss {
            table = table.add(of_energy("per_metre", "energy"), |run| {
                run.summary.quoted_energy()?.per_metre
            });
        }
        let pairs = |run: &ComparedRun| match (run.summary.undecided, &run.summary.loads) {
            (true, _) => Cell::from("undecided"),
            (false, loads) => loads.as_ref().map(|loads| loads.most_tangles as f64).into(),
        };
        let tangles = declared::<Loads>("most_tangles", "tangled pairs", "not known");
        table.add(tangles, pairs).done()
    }

    /// Returns a table of all numbers that a summary has.
    fn whole(&self) -> Table {
        let seed = Column::new("seed", "seed of the random generator");
        let says = "whether the median describes the robot well";
        let reliability = Column::new("reliability", says);
        self.names()
            .add(seed, |run| Cell::Count(run.summary.seed))
            .add(reliability, |run| run.summary.reliability.word())
            .keyed(|run| Some(&run.summary))
            .done()
            .without_empty()
    }

    /// Returns text for a terminal: a table of six columns, or of all with `all`, and then the verdict on each run.
    /// `shown` converts an item of a verdict to text, for example with a colour.
    pub fn to_text(&self, all: bool, shown: impl Fn(&Item) -> String) -> String {
        let table = match all {
            true => self.whole(),
            false => self.short(),
        };
        let verdict = |run: &ComparedRun| match &run.verdict {
            Some(verdict) => format!("{}: {}\n", run.name, verdict.line(&shown)),
            None => format!(
                "{}: no verdict, because its folder has no scene\n",
                run.name
            ),
        };
        let verdicts: String = self.runs.iter().map(verdict).collect();
        let line = |(name, world): (&str, &str)| format!("  {name}: {world}\n");
        let worlds: String = self.worlds().into_iter().map(line).collect();
        let worlds = match worlds.is_empty() {
            true => worlds,
            false => format!("{DIFFER}\n{worlds}"),
        };
        format!("{}\n{verdicts}{worlds}", table.to_text())
    }

    /// The names and the worlds of the runs; empty if all have the same world.
    fn worlds(&self) -> Vec<(&str, &str)> {
        let worlds = self.runs.iter();
        let worlds = worlds.filter_map(|run| Some((&*run.name, run.world.as_deref()?)));
        let worlds: Vec<(&str, &str)> = worlds.collect();
        match worlds.windows(2).all(|pair| pair[0].1 == pair[1].1) {
            true => Vec::new(),
            false => worlds,
        }
    }

    /// Returns a paragraph and a list of HTML if the worlds of the runs differ.
    fn differing_worlds(&self) -> String {
        let worlds = self.worlds();
        if worlds.is_empty() {
            return String::new();
        }
        let line = |(name, world): (&str, &str)| {
            format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(world))
        };
        let lines: String = worlds.into_iter().map(line).collect();
        format!("<p>{DIFFER}</p>\n<dl class=\"verdicts\">\n{lines}</dl>\n")
    }

    /// Returns the verdicts as a list of HTML.
    fn verdicts(&self) -> String {
        let line = |run: &ComparedRun| {
            let verdict = run.verdict.as_ref().map_or(String::new(), line);
            format!("<dt>{}</dt><dd>{verdict}</dd>\n", escape(&run.name))
        };
        let lines: String = self.runs.iter().map(line).collect();
        format!("<dl class=\"verdicts\">\n{lines}</dl>\n")
    }

    /// Returns a page: the verdicts, the robots walking side by side, a table of six columns, and the table of all numbers,
    /// folded. A run without a trajectory does not walk.
    ///
    /// # Errors
    /// The errors of reading designs, scenes and trajectories.
    pub fn to_html(&self, registry: &Registry) -> Result<String> {
        let (title, table) = ("Runs side by side", self.whole().to_html());
        let (verdicts, short) = (self.verdicts(), self.short().to_html());
        let worlds = self.differing_worlds();
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
        // Narrow windows scroll the tables.
        let scrolls = |label: &str, table: &str| {
            format!(
                "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\">{table}</div>"
            )
        };
        let body = format!(
            "<h1>{title}</h1>\n{verdicts}{worlds}{race}{}\n<details><summary>All numbers</summary>\n{}</details>\n",
            scrolls("The most important numbers", &short),
            scrolls("All numbers", &table),
        );
        Ok(page::html(title, &body))
    }
}

/// What comes before the worlds of runs whose worlds differ.
const DIFFER: &str = "The worlds differ, so the distances do not compare the robots alone; in a race all walk by one clock:";

/// Returns the last part of a path, or the whole path if it has none.
fn name(folder: &Path) -> String {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let last = path.file_name().unwrap_or(path.as_os_str());
    last.to_string_lossy().into_owned()
}

/// The declared column `name` of a file, with a title for people and a text for missing numbers.
fn declared<K: Keyed>(name: &str, title: &str, missing: &'static str) -> Column {
    let declared = column::<K>(name);
    let shown = Column::new(title, declared.says).unit(declared.unit);
    shown.decimals(declared.decimals, missing)
}
