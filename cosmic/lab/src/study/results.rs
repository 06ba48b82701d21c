//! The files of a study's results: a document with figures (`.md`), a table of all runs (`.csv`), and the tables of the
//! document with all digits (`.json`).

use super::file::{Trial, Variant};
use super::tables::{DISPLACEMENT, TrialRow, errands, in_mujoco, questions, runs, trials};
use super::work::Study;
use crate::files::{write_text, write_texts};
use crate::report::{Bar, PICTURES, RunFiles, bars};
use crate::table::Table;
use cosmic::error::{Error, Result};
use cosmic::record::files::{Format, make_folder, read_json, write_json};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::num::NonZeroUsize;
use std::path::PathBuf;

const FORMAT: Format = Format::new("cosmic-study", 2);

/// The label of the axis in all charts. It states the unit, and explains the bars, dots and strokes.
const UNIT: &str = "displacement along the ground, m \
    (bar: median; dots: seeds; stroke: the paper, or Coulomb contact in this simulator)";

/// The content of the results' JSON file.
#[derive(Serialize, Deserialize)]
struct Results {
    first_seed: u64,
    seeds: NonZeroUsize,
    /// The settings of the trials. Files of version 1 do not have them.
    #[serde(default)]
    trials: Vec<Settings>,
    #[serde(default)]
    tables: Vec<Value>,
}

/// The settings of a trial that differ from the base of its scene.
#[derive(Serialize, Deserialize)]
struct Settings {
    trial: String,
    settings: Vec<String>,
}

impl Results {
    /// Returns the results of a study with an empty list of tables.
    fn of<'t>(study: &Study, trials: impl IntoIterator<Item = &'t Trial>) -> Self {
        let limit = study.iterations.map_or("all".to_owned(), |n| n.to_string());
        let settings = |Trial { name, scene, .. }: &Trial| {
            let changed = scene.changed().into_iter();
            let changed = changed.map(|setting| format!("{}={}", setting.key, setting.value));
            let base = format!("base={}", scene.base.name());
            let all = changed.chain([base, format!("iterations={limit}")]);
            let (trial, settings) = (name.clone(), all.collect());
            Settings { trial, settings }
        };
        Self {
            first_seed: study.first_seed,
            seeds: study.seeds,
            trials: trials.into_iter().map(settings).collect(),
            tables: Vec::new(),
        }
    }

    /// Finds the first setting that differs between the existing results (`self`) and the new results (`now`). Returns
    /// its name, its existing value and its new value.
    fn differs(&self, now: &Self) -> Option<[String; 3]> {
        let last = |s: &Self| s.first_seed.saturating_add(s.seeds.get() as u64 - 1);
        if self.first_seed < now.first_seed || last(self) > last(now) {
            let [before, now] = [self, now].map(|s| format!("{} to {}", s.first_seed, last(s)));
            return Some(["seeds".to_owned(), before, now]);
        }
        let only = |a: &[String], b: &[String]| a.iter().find(|word| !b.contains(word)).cloned();
        self.trials.iter().find_map(|Settings { trial, settings }| {
            let now = now.trials.iter().find(|now| now.trial == *trial);
            let now = now.map_or(&[][..], |now| &now.settings);
            let [before, now] = [only(settings, now), only(now, settings)];
            let differs = before.is_some() || now.is_some();
            let usual = || "as in the base".to_owned();
            let [before, now] = [before, now].map(|word| word.unwrap_or_else(usual));
            differs.then_some([trial.clone(), before, now])
        })
    }
}

impl Study {
    /// The path of the results file with this file extension.
    fn place(&self, extension: &str) -> PathBuf {
        self.out.join(format!("{}.{extension}", self.file.name))
    }

    /// Checks whether the results may be written. If results exist, they must have the same settings, and this study
    /// must have all of their seeds.
    ///
    /// # Errors
    /// [`Error::Usage`] if existing results are from other settings or seeds; the errors of reading the study's scenes;
    /// the errors of [`read_json`].
    pub fn check_results(&self) -> Result<()> {
        let path = self.place("json");
        if path.exists() {
            let version_1 = Format::new(FORMAT.name, 1);
            let before = read_json(&path, version_1).or_else(|_| read_json(&path, FORMAT));
            let (before, trials): (Results, _) =
                (before?, self.file.trials(&self.base, &self.registry)?);
            if let Some([what, before, now]) = before.differs(&Results::of(self, &trials)) {
                return Err(Error::Usage(format!(
                    "{}: {what}: {before} in the existing results, but {now} in this study; name \
                     another folder with --out",
                    path.display()
                )));
            }
        }
        Ok(())
    }

    /// Writes the results and returns the paths.
    pub(super) fn write_results(&self, rows: &[TrialRow]) -> Result<Vec<PathBuf>> {
        let keys = &self.file.keys;
        let command = format!("```sh\n{}\n```\n", self.command());
        let mut text = format!("# {}\n\n{}\n{command}", keys.title, keys.about);
        let mut results = Results::of(self, rows.iter().map(|row| &row.trial));
        let of_trials = |variant| trials(variant, &rows_of(rows, variant));
        let mut tables: Vec<Table> = keys.variants.iter().map(of_trials).collect();
        tables.extend(errands(rows));
        tables.extend((!keys.mujoco.is_empty()).then(|| in_mujoco(&keys.mujoco, rows)));
        tables.extend((!keys.questions.is_empty()).then(|| questions(&keys.questions, rows)));
        for table in &tables {
            let mut variants = keys.variants.iter();
            let variant = variants.find(|variant| variant.name == table.name);
            let about = variant.map_or(String::new(), |variant| variant.about.clone() + "\n");
            text += &format!("\n## {}\n\n{about}{}", table.title, table.to_markdown());
            let (name, rows) = (&table.name, table.to_json()["rows"].take());
            results.tables.push(json!({ "table": name, "rows": rows }));
        }
        let mut written = self.write_figures(rows, &mut text)?;
        text += &include_str!("about.md").replace("NAME", &self.file.name);
        let paths = ["md", "csv", "json"].map(|extension| self.place(extension));
        write_text(&paths[0], &text)?;
        write_text(&paths[1], &runs(rows).to_csv())?;
        write_json(&paths[2], FORMAT, &results)?;
        written.extend(paths);
        Ok(written)
    }

    /// Draws a chart for each table. Also draws pictures of the best run of each trial of the first table. Adds links
    /// to all of them to `text`.
    fn write_figures(&self, rows: &[TrialRow], text: &mut String) -> Result<Vec<PathBuf>> {
        let (keys, name) = (&self.file.keys, &self.file.name);
        let mut drawn = Vec::new();
        for variant in &keys.variants {
            let rows = rows_of(rows, variant).into_iter();
            let all: Vec<Bar> = rows.flat_map(|row| bars_of(row, &keys.mujoco)).collect();
            let file = format!("{}.svg", variant.name);
            *text += &format!("\n![every seed]({name}/{file})\n");
            drawn.push((file, bars("Every seed of every trial", UNIT, &all)));
        }
        let best = rows_of(rows, &keys.variants[0]).into_iter();
        let best = best.filter_map(|row| Some((&row.trial, row.best()?)));
        for (trial, best) in best.filter(|_| !keys.pictures.is_empty()) {
            *text += &format!("\n## The best of {}: seed {}\n\n", trial.title, best.seed);
            let run = RunFiles::read(&best.folder, &self.registry)?;
            let is_asked = |picture: &str| keys.pictures.iter().any(|asked| asked == picture);
            for (picture, draw) in PICTURES.iter().filter(|(picture, _)| is_asked(picture)) {
                let file = format!("{}-{picture}.svg", trial.name);
                *text += &format!("![{picture}]({name}/{file})\n");
                drawn.push((file, draw(&run)));
            }
        }
        let folder = self.out.join(name);
        make_folder(&folder)?;
        write_texts(&folder, drawn)
    }
}

fn rows_of<'r>(rows: &'r [TrialRow], variant: &Variant) -> Vec<&'r TrialRow> {
    let rows = rows.iter();
    rows.filter(|row| row.trial.table == variant.name).collect()
}

/// The bars that a chart shows for a trial: one for the trial's own scene, and one for each friction in MuJoCo.
fn bars_of(row: &TrialRow, frictions: &[f64]) -> Vec<Bar> {
    let bar = |name: String, column: &str, mark: Option<f64>| Bar {
        name,
        value: row.of(column).median,
        points: row.sample(column),
        mark,
    };
    let title = &row.trial.title;
    let mut bars = vec![bar(title.clone(), DISPLACEMENT, row.trial.paper)];
    for friction in frictions {
        let [there, own] = ["mujoco", "coulomb"].map(|name| format!("{name}_{friction}"));
        bars.push(bar(
            format!("{title}, friction {friction}"),
            &there,
            row.of(&own).median,
        ));
    }
    bars
}
