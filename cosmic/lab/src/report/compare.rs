//! Runs side by side.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::page::{self, Figure};
use super::sheet::aligned;
use super::svg::escape;
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

    /// What is shown of every run.
    fn figures(&self) -> Vec<Figure> {
        page::figures_of(self.runs.iter().map(|run| &run.summary))
    }

    /// A row a run, aligned for a terminal, ordered as the runs were given.
    pub fn to_text(&self) -> String {
        let figures = self.figures();
        let head = std::iter::once("run".to_owned());
        let shorts = figures.iter().map(|f| f.short.to_owned());
        let mut rows: Vec<Vec<String>> = vec![head.chain(shorts).collect()];
        rows.extend(self.runs.iter().map(|run| run.cells(&figures)));
        aligned(&rows)
    }

    /// A page with a row a run.
    pub fn to_html(&self) -> String {
        let mut table = String::from("<table><thead><tr><th>run</th>");
        let figures = self.figures();
        for figure in &figures {
            // Writing to a string cannot fail, here and below.
            let _ = write!(
                table,
                r#"<th title="{}">{}</th>"#,
                figure.says, figure.short
            );
        }
        table += "<th>departures from the paper</th></tr></thead><tbody>";
        for run in &self.runs {
            let cells = run.cells(&figures);
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
    fn cells(&self, figures: &[Figure]) -> Vec<String> {
        let name = std::iter::once(self.name.clone());
        name.chain(figures.iter().map(|f| (f.of)(&self.summary)))
            .collect()
    }
}

/// The last part of a path, or all of a path that has none.
fn name(folder: &Path) -> String {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    let last = path.file_name().unwrap_or(path.as_os_str());
    last.to_string_lossy().into_owned()
}
