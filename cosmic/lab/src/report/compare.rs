//! Runs side by side.

use super::html;
use super::numbers::summary_columns;
use crate::table::{Cell, Column, Table};
use cosmic::error::Result;
use cosmic::record::Summary;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The summaries of several runs.
#[derive(Debug, Serialize)]
pub struct Comparison {
    runs: Vec<ComparedRun>,
}

/// One run.
#[derive(Debug, Serialize)]
struct ComparedRun {
    /// The name of its folder, or the whole path where another run has that name.
    #[serde(rename = "run")]
    name: String,
    summary: Summary,
}

impl Comparison {
    /// Reads the summaries of runs.
    ///
    /// # Errors
    /// Those of [`Summary::read`].
    pub fn read(folders: &[PathBuf]) -> Result<Self> {
        let names: Vec<String> = folders.iter().map(|folder| name(folder)).collect();
        let run = |(folder, name): (&PathBuf, &String)| {
            let mut others = folders.iter().zip(&names);
            let has_namesake = others.any(|(other, of)| of == name && other != folder);
            let path = || folder.display().to_string();
            Ok(ComparedRun {
                name: if has_namesake { path() } else { name.clone() },
                summary: Summary::read(folder)?,
            })
        };
        let runs = folders.iter().zip(&names).map(run);
        Ok(Self {
            runs: runs.collect::<Result<_>>()?,
        })
    }

    /// A row a run, ordered as the runs were given.
    fn table(&self) -> Table {
        let summaries: Vec<&Summary> = self.runs.iter().map(|run| &run.summary).collect();
        let columns = summary_columns(&summaries);
        let row = |run: &ComparedRun| {
            let name = Cell::from(run.name.clone());
            let cells = columns.iter().map(|column| (column.of)(&run.summary));
            std::iter::once(name).chain(cells).collect()
        };
        let rows: Vec<_> = self.runs.iter().map(row).collect();
        let heads = columns.into_iter().map(|column| column.column);
        let heads = std::iter::once(Column::new("run", "")).chain(heads);
        Table::new(heads.collect(), rows)
    }

    /// The table, aligned for a terminal.
    pub fn to_text(&self) -> String {
        self.table().to_text()
    }

    /// A page with the table.
    pub fn to_html(&self) -> String {
        let mut table = self.table();
        let departures = "departures from the paper";
        table.columns.push(Column::new(departures, ""));
        for (row, run) in table.rows.iter_mut().zip(&self.runs) {
            let departures = run.summary.departures.iter();
            let names: Vec<&str> = departures.map(|d| &d.option[..]).collect();
            let none = ["none"];
            let names = if names.is_empty() { &none } else { &names[..] };
            row.cells.push(names.join(", ").into());
        }
        let title = "Runs side by side";
        html::page(title, &format!("<h1>{title}</h1>{}", table.to_html()))
    }
}

/// The last part of a path, or all of a path that has none.
fn name(folder: &Path) -> String {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let last = path.file_name().unwrap_or(path.as_os_str());
    last.to_string_lossy().into_owned()
}
