//! Runs side by side.

use std::path::{Path, PathBuf};

use super::html;
use super::numbers::summary_columns;
use crate::table::{self, Cell, Table};
use cosmic::error::Result;
use cosmic::record::Summary;

/// The summaries of several runs.
#[derive(Debug)]
pub struct Comparison {
    runs: Vec<Column>,
}

/// One run.
#[derive(Debug)]
struct Column {
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
        let column = |(folder, name): (&PathBuf, &String)| {
            let mut others = folders.iter().zip(&names);
            let has_namesake = others.any(|(other, of)| of == name && other != folder);
            Ok(Column {
                name: match has_namesake {
                    true => folder.display().to_string(),
                    false => name.clone(),
                },
                summary: Summary::read(folder)?,
            })
        };
        let runs = folders.iter().zip(&names).map(column);
        Ok(Self {
            runs: runs.collect::<Result<_>>()?,
        })
    }

    /// A row a run, ordered as the runs were given.
    fn table(&self) -> Table {
        let summaries: Vec<&Summary> = self.runs.iter().map(|run| &run.summary).collect();
        let columns = summary_columns(&summaries);
        let row = |run: &Column| {
            let name = Cell::from(run.name.clone());
            let cells = columns.iter().map(|column| (column.of)(&run.summary));
            std::iter::once(name).chain(cells).collect()
        };
        let rows: Vec<_> = self.runs.iter().map(row).collect();
        let heads = columns.into_iter().map(|column| column.column);
        let heads = std::iter::once(table::Column::new("run", "")).chain(heads);
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
        table.columns.push(table::Column::new(departures, ""));
        for (row, run) in table.rows.iter_mut().zip(&self.runs) {
            let departures = run.summary.departures.iter();
            let names: Vec<&str> = departures.map(|d| &d.option[..]).collect();
            row.cells.push(match names.is_empty() {
                true => "none".into(),
                false => names.join(", ").into(),
            });
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
