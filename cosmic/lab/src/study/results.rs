//! A study's results, and their files.

use super::Study;
use super::check::Check;
use super::in_mujoco::{FRICTIONS, Transfer};
use super::motifs::MotifRow;
use super::rows::{RunRow, TrialRow};
use super::trials::Trial;
use crate::files::write_text;
use crate::table::{Cell, Table};
use cosmic::error::{Error, Result};
use cosmic::record::files::{Format, read_json, write_json};
use cosmic::record::summary::NUMBERS;
use cosmic::scene::Scene;
use serde::{Deserialize, Serialize};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// The format of the results.
const FORMAT: Format = Format {
    name: "cosmic-study",
    version: 1,
};

/// The results of a study.
#[derive(Clone, Debug, Serialize)]
pub(super) struct StudyResults {
    #[serde(flatten)]
    pub(super) settings: Provenance,
    pub(super) rows: Vec<TrialRow>,
    pub(super) motifs: Vec<MotifRow>,
}

/// The settings of the study that made the results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Provenance {
    study: String,
    first_seed: u64,
    seeds: NonZeroUsize,
    iterations: Option<NonZeroUsize>,
    /// Settings under those of every scene, TOML. Results of older versions lack it.
    #[serde(default)]
    base: Option<String>,
}

impl StudyResults {
    /// The trial with this name, which must be one of the study's.
    pub(super) fn row(&self, name: &str) -> &TrialRow {
        let row = self.rows.iter().find(|row| row.trial.name == name);
        row.expect("a study has all of its trials")
    }

    /// The trials of a table.
    pub(super) fn table(&self, table: &str) -> Vec<&TrialRow> {
        let rows = self.rows.iter();
        rows.filter(|row| row.trial.table == table).collect()
    }

    /// Writes the document, a table with a row per run, and all numbers; returns the paths.
    pub(super) fn write(&self, study: &Study, document: &str) -> Result<[PathBuf; 3]> {
        let paths = ["md", "csv", "json"].map(|kind| place(study, kind));
        for (path, text) in paths.iter().zip([document, &self.runs().to_csv()]) {
            write_text(path, text)?;
        }
        write_json(&paths[2], FORMAT, self)?;
        Ok(paths)
    }

    /// A row per run; a number that a run lacks is left empty.
    fn runs(&self) -> Table {
        let trials = self.rows.iter();
        let runs: Vec<Pair> = trials
            .flat_map(|row| row.runs.iter().map(|run| (&row.trial, run)))
            .collect();
        type Pair<'p> = (&'p Trial, &'p RunRow);
        let of_summary = |(_, run): &Pair, k: usize| run.summary.as_ref().and_then(NUMBERS[k].1);
        let of_check = |(_, run): &Pair, k: usize| run.check.as_ref().and_then(OF_CHECK[k].1);
        let table = Table::of("", "", &runs)
            .column("table", "", |(trial, _)| trial.table)
            .column("trial", "", |(trial, _)| &trial.name[..])
            .column("seed", "", |(_, run)| Cell::Count(run.seed))
            .columns(NUMBERS.map(|(name, _)| name), "", of_summary)
            .columns(OF_CHECK.map(|(name, _)| name), "", of_check);
        if self.rows.iter().all(|row| row.on_frictions.is_empty()) {
            return table.done();
        }
        let of_transfer = |run: &RunRow, number: fn(&Transfer, usize) -> Option<f64>, k: usize| {
            number(run.transfer.as_ref()?, k)
        };
        let names = |what: &str| FRICTIONS.map(|friction| format!("{what}_{friction}"));
        table
            .columns(names("mujoco"), "", |(_, run), k| {
                of_transfer(run, Transfer::there, k)
            })
            .columns(names("coulomb"), "", |(_, run), k| {
                of_transfer(run, Transfer::own, k)
            })
            .done()
    }

    /// Refuses to replace results that the study would not repeat: those of other settings, or of seeds
    /// that it lacks.
    ///
    /// # Errors
    /// [`Error::Usage`]; those of [`read_json`].
    pub(super) fn may_replace(study: &Study) -> Result<()> {
        let path = place(study, "json");
        if !path.exists() {
            return Ok(());
        }
        let (before, now): (Provenance, _) = (read_json(&path, FORMAT)?, Provenance::of(study));
        match before.differs(&now) {
            None => Ok(()),
            Some([what, before, now]) => Err(Error::Usage(format!(
                "{}: {what}: {before} in the results there, {now} in this study; name another \
                 folder by --out",
                path.display()
            ))),
        }
    }
}

impl Provenance {
    pub(super) fn of(study: &Study) -> Self {
        Self {
            study: study.kind.name().to_owned(),
            first_seed: study.first_seed,
            seeds: study.seeds,
            iterations: study.iterations,
            base: Some(study.base.text.clone()),
        }
    }

    /// The first setting that differs between these results and new ones: its name, and both values.
    fn differs(&self, now: &Self) -> Option<[String; 3]> {
        let last = |s: &Self| s.first_seed.saturating_add(s.seeds.get() as u64 - 1);
        if self.first_seed < now.first_seed || last(self) > last(now) {
            let [before, now] = [self, now].map(|s| format!("{} to {}", s.first_seed, last(s)));
            return Some(["seeds".to_owned(), before, now]);
        }
        let settings = |settings: &Self| {
            let most = settings.iterations;
            let most = most.map_or("all".to_owned(), |n| n.to_string());
            // Results without a base may have any.
            let base = self.base.as_ref().and(settings.base.as_deref());
            let base = Scene::paper().with("--base", base.unwrap_or_default());
            let mut all = vec![["iterations".to_owned(), most]];
            if let Ok(base) = base {
                all.extend(base.settings().into_iter().map(|s| [s.key, s.value]));
            }
            all
        };
        let mut pairs = settings(self).into_iter().zip(settings(now));
        let ([key, before], [_, now]) = pairs.find(|(before, now)| before != now)?;
        Some([key, before, now])
    }
}

/// A file of a study's results.
fn place(study: &Study, extension: &str) -> PathBuf {
    let name = Path::new(study.kind.name()).with_extension(extension);
    study.out.join(name)
}

/// A number of a check; `None` if a rollout diverged.
type OfCheck = fn(&Check) -> Option<f64>;

/// Numbers of a check, each with the name of its column. True is 1.
const OF_CHECK: [(&str, OfCheck); 6] = [
    ("half_step_p50", |c| c.half_step[1]),
    ("half_step_p10", |c| c.half_step[0]),
    ("half_step_p90", |c| c.half_step[2]),
    ("goal_behind_p50", |c| c.goal_behind),
    ("one_hot", |c| Some(f64::from(c.one_hot))),
    ("within_bounds", |c| Some(f64::from(c.within_bounds))),
];
