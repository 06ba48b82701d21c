//! A study's results as Markdown, CSV and JSON.

use super::motifs::MotifRow;
use super::rows::Row;
use super::{Check, Study};
use crate::table::{Cell, Column, Table};
use cosmic::error::Result;
use cosmic::record::files::{Format, write_atomic, write_json};
use cosmic::record::summary::NUMBERS;
use serde::Serialize;
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// What the results say they are.
const FORMAT: Format = Format {
    name: "cosmic-study",
    version: 1,
};

/// All that a study found.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Results {
    pub(super) study: &'static str,
    pub(super) first_seed: u64,
    pub(super) seeds: NonZeroUsize,
    pub(super) iterations: Option<NonZeroUsize>,
    pub(super) rows: Vec<Row>,
    pub(super) motifs: Vec<MotifRow>,
}

impl Results {
    /// Rows of a study, before their designs are looked at.
    pub(super) fn of_rows(study: &Study, rows: Vec<Row>) -> Self {
        Self {
            study: study.kind.name(),
            first_seed: study.first_seed,
            seeds: study.seeds,
            iterations: study.iterations,
            motifs: Vec::new(),
            rows,
        }
    }

    /// The trial of a name; a study has all of its trials.
    pub(super) fn row(&self, name: &str) -> &Row {
        let row = self.rows.iter().find(|row| row.name == name);
        row.expect("a study has all of its trials")
    }

    /// The trials of a table.
    pub(super) fn table(&self, table: &str) -> Vec<&Row> {
        self.rows.iter().filter(|row| row.table == table).collect()
    }
}

/// Writes the three files and says where they are.
pub(super) fn write(study: &Study, results: &Results, document: &str) -> Result<[PathBuf; 3]> {
    let name = study.kind.name();
    let paths = ["md", "csv", "json"].map(|kind| study.out.join(format!("{name}.{kind}")));
    let table = table(results).to_csv();
    for (path, text) in paths.iter().zip([document, &table]) {
        write_atomic(path, |file| file.write_all(text.as_bytes()))?;
    }
    write_json(&paths[2], FORMAT, results)?;
    Ok(paths)
}

/// A number of a check; `None` where a rollout diverged.
type OfCheck = fn(&Check) -> Option<f64>;

/// Numbers of a check, each with the name of its column; what holds is 1.
const OF_CHECK: [(&str, OfCheck); 6] = [
    ("half_step_p50", |c| c.half_step[1]),
    ("half_step_p10", |c| c.half_step[0]),
    ("half_step_p90", |c| c.half_step[2]),
    ("goal_behind_p50", |c| c.goal_behind),
    ("one_hot", |c| Some(f64::from(u8::from(c.one_hot)))),
    ("within_bounds", |c| {
        Some(f64::from(u8::from(c.within_bounds)))
    }),
];

/// A row a run; what a run does not have is left empty.
fn table(results: &Results) -> Table {
    let of_summary = NUMBERS.map(|(name, _)| name);
    let of_check = OF_CHECK.map(|(name, _)| name);
    let names = [&["table", "trial", "seed"], &of_summary[..], &of_check].concat();
    let columns = names
        .iter()
        .map(|name| Column::new(name, "").decimals(2, "-"));
    let rows = results.rows.iter().flat_map(|row| {
        row.runs.iter().map(|run| {
            let summary = NUMBERS.map(|(_, of)| run.summary.as_ref().and_then(of));
            let check = OF_CHECK.map(|(_, of)| run.check.as_ref().and_then(of));
            let numbers = summary.into_iter().chain(check).map(Cell::from);
            let names = [
                row.table[..].into(),
                row.name[..].into(),
                Cell::Count(run.seed),
            ];
            names.into_iter().chain(numbers).collect()
        })
    });
    Table::new(columns.collect(), rows)
}
