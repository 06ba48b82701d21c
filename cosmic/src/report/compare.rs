//! Runs side by side.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::page;
use super::svg::escape;
use crate::error::Result;
use crate::record::Summary;

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
        let column = |folder: &PathBuf| {
            Ok(Column {
                name: name(folder),
                summary: Summary::read(folder)?,
            })
        };
        let runs = folders.iter().map(column).collect::<Result<_>>()?;
        Ok(Self { runs })
    }

    /// A row a run, aligned for a terminal, ordered as the runs were given.
    pub fn to_text(&self) -> String {
        let head = std::iter::once("run".to_owned());
        let mut rows = vec![
            head.chain(page::FIGURES.map(|f| f.short.to_owned()))
                .collect(),
        ];
        rows.extend(self.runs.iter().map(Column::cells));
        let width = |k: usize| {
            rows.iter()
                .map(|r: &Vec<String>| r[k].chars().count())
                .max()
        };
        let widths: Vec<usize> = (0..rows[0].len()).map(|k| width(k).unwrap_or(0)).collect();
        let mut text = String::new();
        for row in &rows {
            let mut line = format!("{:w$}", row[0], w = widths[0]);
            for (cell, w) in row.iter().zip(&widths).skip(1) {
                // Writing to a string cannot fail.
                let _ = write!(line, "  {cell:>w$}");
            }
            text += line.trim_end();
            text.push('\n');
        }
        text
    }

    /// A page with a row a run.
    pub fn to_html(&self) -> String {
        let mut table = String::from("<table><thead><tr><th>run</th>");
        for figure in &page::FIGURES {
            let _ = write!(
                table,
                r#"<th title="{}">{}</th>"#,
                figure.says, figure.short
            );
        }
        table += "<th>departures from the paper</th></tr></thead><tbody>";
        for run in &self.runs {
            let cells = run.cells();
            let _ = write!(table, "<tr><td>{}</td>", escape(&cells[0]));
            for cell in &cells[1..] {
                let _ = write!(table, r#"<td class="number">{}</td>"#, escape(cell));
            }
            let departures = run.summary.departures.iter();
            let names: Vec<&str> = departures.map(|d| &d.option[..]).collect();
            let names = if names.is_empty() {
                "none".to_owned()
            } else {
                names.join(", ")
            };
            let _ = write!(table, "<td>{}</td></tr>", escape(&names));
        }
        table += "</tbody></table>";
        page::wrap(
            "Runs side by side",
            &format!("<h1>Runs side by side</h1>{table}"),
        )
    }
}

impl Column {
    fn cells(&self) -> Vec<String> {
        let name = std::iter::once(self.name.clone());
        name.chain(page::FIGURES.map(|f| (f.of)(&self.summary)))
            .collect()
    }
}

/// The last part of a path, or all of a path that has none.
fn name(folder: &Path) -> String {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let last = path.file_name().unwrap_or(path.as_os_str());
    last.to_string_lossy().into_owned()
}
