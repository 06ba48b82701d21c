//! The files of a study's results: a document with figures, and the numbers.

use super::file::Trial;
use super::rows::{DISPLACEMENT, Run, TrialRow};
use super::study::Study;
use super::tables::{departures, in_mujoco, questions, runs, trials};
use crate::files::{write_text, write_texts};
use crate::report::{Bar, PICTURES, RunFiles, bars};
use cosmic::error::{Error, Result};
use cosmic::record::files::{Format, make_folder, read_json, write_json};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::num::NonZeroUsize;
use std::path::PathBuf;

const FORMAT: Format = Format::new("cosmic-study", 2);

/// The unit of all bars.
const UNIT: &str = "displacement along the ground, m \
    (bar: median; dots: seeds; stroke: the paper's, or Coulomb here)";

/// The settings that results were made with.
#[derive(Serialize, Deserialize)]
struct Provenance {
    first_seed: u64,
    seeds: NonZeroUsize,
    iterations: Option<NonZeroUsize>,
    /// For each trial the settings that differ from its base. Version 1 lacks them.
    #[serde(default)]
    settings: BTreeMap<String, BTreeMap<String, String>>,
}

/// The numbers, for a file.
#[derive(Serialize)]
struct Numbers {
    study: String,
    #[serde(flatten)]
    provenance: Provenance,
    /// For each table its rows.
    tables: Map<String, Value>,
}

impl Provenance {
    fn of<'t>(study: &Study, trials: impl IntoIterator<Item = &'t Trial>) -> Self {
        let settings = |trial: &Trial| {
            let changed = trial.scene.changed().into_iter();
            let base = ("base".to_owned(), trial.scene.base.name().to_owned());
            let settings = changed
                .map(|setting| (setting.key, setting.value))
                .chain([base]);
            (trial.name.clone(), settings.collect())
        };
        Self {
            first_seed: study.first_seed,
            seeds: study.seeds,
            iterations: study.iterations,
            settings: trials.into_iter().map(settings).collect(),
        }
    }

    /// What new results would not repeat of these: its name, and both values.
    fn differs(&self, now: &Self) -> Option<[String; 3]> {
        let last = |s: &Self| s.first_seed.saturating_add(s.seeds.get() as u64 - 1);
        if self.first_seed < now.first_seed || last(self) > last(now) {
            let [before, now] = [self, now].map(|s| format!("{} to {}", s.first_seed, last(s)));
            return Some(["seeds".to_owned(), before, now]);
        }
        if self.iterations != now.iterations {
            let most = |s: &Self| s.iterations.map_or("all".to_owned(), |n| n.to_string());
            return Some(["iterations".to_owned(), most(self), most(now)]);
        }
        self.settings.iter().find_map(|(trial, before)| {
            let Some(now) = now.settings.get(trial) else {
                return Some([trial.clone(), "a trial".to_owned(), "none".to_owned()]);
            };
            let mut keys = before.keys().chain(now.keys());
            let key = keys.find(|key| before.get(*key) != now.get(*key))?;
            let usual = || "the base's".to_owned();
            let [before, now] = [before, now].map(|s| s.get(key).cloned().unwrap_or_else(usual));
            Some([key.clone(), before, now])
        })
    }
}

impl Study {
    /// A file of the results.
    fn place(&self, extension: &str) -> PathBuf {
        self.out.join(format!("{}.{extension}", self.file.name))
    }

    /// Makes the folder of the results, and checks that they may be written there: over results of the same settings
    /// and of these seeds or fewer.
    ///
    /// # Errors
    /// [`Error::Usage`]; the errors of the file's scenes; those of [`read_json`] and [`make_folder`].
    pub fn check_results(&self) -> Result<()> {
        let path = self.place("json");
        if path.exists() {
            let version_1 = Format {
                version: 1,
                ..FORMAT
            };
            let before = read_json(&path, version_1).or_else(|_| read_json(&path, FORMAT));
            let before: Provenance = before?;
            let now = Provenance::of(self, &self.file.trials(&self.base)?);
            if let Some([what, before, now]) = before.differs(&now) {
                return Err(Error::Usage(format!(
                    "{}: {what}: {before} in the results there, {now} in this study; name another \
                     folder by --out",
                    path.display()
                )));
            }
        }
        make_folder(&self.out)
    }

    /// Writes the results and returns the paths.
    pub(super) fn write_results(&self, rows: &[TrialRow]) -> Result<Vec<PathBuf>> {
        let (keys, name) = (&self.file.keys, &self.file.name);
        let (mut text, mut tables) = (self.heading(), Map::new());
        for table in self.file.tables() {
            let rows = &rows_of(rows, &table.name);
            let (trials, chart) = (trials(rows), self.chart(&table.name));
            let heading = table.title.as_deref().unwrap_or("Trials");
            let (about, legend) = (block(&table.about), legend(rows));
            text += &format!(
                "\n## {heading}\n\n{about}{}\n{legend}\n![every seed]({name}/{chart}.svg)\n",
                trials.to_markdown()
            );
            tables.insert(table.name, trials.to_json()["rows"].take());
        }
        if !keys.mujoco.is_empty() {
            let versions = rows.iter().flat_map(|row| &row.runs);
            let versions: BTreeSet<&str> =
                versions.filter_map(|run| run.mujoco.as_deref()).collect();
            let versions = Vec::from_iter(versions).join(" and ");
            let walks = in_mujoco(keys, rows);
            text += &format!("\n## In MuJoCo {versions}\n\n{}", walks.to_markdown());
            tables.insert("mujoco".to_owned(), walks.to_json()["rows"].take());
        }
        if !keys.questions.is_empty() {
            let questions = questions(keys, rows);
            text += &format!("\n## Questions\n\n{}", questions.to_markdown());
            tables.insert("questions".to_owned(), questions.to_json()["rows"].take());
        }
        let mut written = self.write_figures(rows, &mut text)?;
        let about = include_str!("about.md").replace("NAME", name);
        text += &about.replace("COMMAND", &self.command());
        let numbers = Numbers {
            study: name.clone(),
            provenance: Provenance::of(self, rows.iter().map(|row| &row.trial)),
            tables,
        };
        let paths = ["md", "csv", "json"].map(|extension| self.place(extension));
        write_text(&paths[0], &text)?;
        write_text(&paths[1], &runs(rows).to_csv())?;
        write_json(&paths[2], FORMAT, &numbers)?;
        written.extend(paths);
        Ok(written)
    }

    /// The title, the seeds, and what was changed for all trials.
    fn heading(&self) -> String {
        let keys = &self.file.keys;
        let (seeds, first) = (self.seeds.get() as u64, self.first_seed);
        let seeds = match seeds {
            1 => format!("seed {first}"),
            _ => format!("{seeds} seeds, {first} to {}", first + (seeds - 1)),
        };
        let limit = self.iterations.map_or(String::new(), |n| {
            format!(
                " **Every run was stopped after {n} iterations: a shortened trial of the study.**"
            )
        });
        let base = match &self.base.file[..] {
            "" => String::new(),
            file => format!(" The settings of `{file}` are under every scene."),
        };
        let (title, about) = (&keys.title, block(&keys.about));
        format!("# {title}\n\n{about}Displacements in metres over {seeds}.{limit}{base}\n")
    }

    /// The name of a table's chart.
    fn chart<'n>(&self, table: &'n str) -> &'n str {
        if table == self.file.name {
            "trials"
        } else {
            table
        }
    }

    /// Writes the charts of all tables and the pictures of the best runs; adds these to the document.
    fn write_figures(&self, rows: &[TrialRow], text: &mut String) -> Result<Vec<PathBuf>> {
        let (keys, name) = (&self.file.keys, &self.file.name);
        let mut drawn = Vec::new();
        for (k, table) in self.file.tables().iter().enumerate() {
            let rows = rows_of(rows, &table.name);
            let all: Vec<Bar> = rows
                .iter()
                .flat_map(|row| bars_of(row, &keys.mujoco))
                .collect();
            let chart = bars("Every seed of every trial", UNIT, &all);
            drawn.push((format!("{}.svg", self.chart(&table.name)), chart));
            if k > 0 || keys.pictures.is_empty() {
                continue;
            }
            *text += "\n## The best seed of each trial\n";
            for (row, best) in rows.iter().filter_map(|row| Some((row, row.best()?))) {
                *text += &format!("\n### {}, seed {}\n\n", row.trial.title, best.seed);
                let run = RunFiles::read(&best.folder)?;
                for (picture, draw) in PICTURES {
                    if keys.pictures.iter().any(|wanted| wanted == picture) {
                        let file = format!("{}-{picture}.svg", row.trial.name);
                        *text += &format!("![{picture}]({name}/{file})\n");
                        drawn.push((file, draw(&run)));
                    }
                }
            }
        }
        let folder = self.out.join(name);
        make_folder(&folder)?;
        write_texts(&folder, drawn)
    }
}

fn rows_of<'r>(rows: &'r [TrialRow], table: &str) -> Vec<&'r TrialRow> {
    rows.iter().filter(|row| row.trial.table == table).collect()
}

/// Markdown, and an empty line after it if it is not empty.
fn block(text: &str) -> String {
    if text.is_empty() {
        String::new()
    } else {
        format!("{}\n\n", text.trim())
    }
}

/// The legend of the letters in the column `departures`.
fn legend(rows: &[&TrialRow]) -> String {
    let known = departures(rows);
    let lines = ('A'..).zip(&known);
    let lines = lines.map(|(letter, d)| format!("- {letter}: `{}`, {}\n", d.option, d.says));
    match known.len() {
        0 => "Departures from the paper: none.\n".to_owned(),
        _ => "Departures from the paper:\n\n".to_owned() + &lines.collect::<String>(),
    }
}

/// The bars of a trial: as designed, and in MuJoCo on each friction.
fn bars_of(row: &TrialRow, frictions: &[f64]) -> Vec<Bar> {
    let bar = |name: String, column: &str, mark: Option<f64>| Bar {
        name,
        value: row.of(column).median,
        points: row
            .runs
            .iter()
            .filter_map(|run: &Run| run.number(column))
            .collect(),
        mark,
    };
    let title = &row.trial.title;
    let designed = bar(title.clone(), DISPLACEMENT, row.trial.paper);
    let there = frictions.iter().map(|friction| {
        let own = row.of(&format!("coulomb_{friction}")).median;
        bar(
            format!("{title}, friction {friction}"),
            &format!("mujoco_{friction}"),
            own,
        )
    });
    [designed].into_iter().chain(there).collect()
}
