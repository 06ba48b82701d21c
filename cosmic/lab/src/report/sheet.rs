//! Writes the results of a check as text, as JSON, as an HTML page with charts, and as CSV files.

use super::page;
use crate::files::write_texts;
use crate::table::{Emphasis, Table, aligned, escape, prose};
use cosmic::error::{Error, Result};
use cosmic::judge::verdict::{Item, Level};
use cosmic::record::files::make_folder;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A chart, which the page draws.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Chart {
    /// The heading: the quantity of the vertical axis, with its unit.
    pub title: String,
    /// The quantity of the horizontal axis, with its unit.
    pub along: String,
    /// Whether the horizontal axis and the vertical axis are logarithmic.
    pub is_log: [bool; 2],
    /// The lines.
    pub lines: Vec<Line>,
}

/// A line of a chart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// The name in the legend.
    pub name: String,
    /// The points. The page leaves out points that are not finite.
    pub points: Vec<[f64; 2]>,
}

impl Line {
    /// A line with this name and these points.
    pub fn new(name: &str, points: impl Iterator<Item = [f64; 2]>) -> Self {
        Self {
            name: name.to_owned(),
            points: points.collect(),
        }
    }
}

/// A section of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// The heading.
    pub title: String,
    /// The results as text for a terminal, in place of the tables and notes.
    pub text: String,
    /// Answers in plain words, each with its level.
    pub answers: Vec<Item>,
    /// Explanations for the page that come before the tables.
    pub notes: Vec<String>,
    /// The tables. Each is also written as a file `name.csv`.
    pub tables: Vec<Table>,
    /// The charts of the page.
    pub charts: Vec<Chart>,
    /// The number of checks.
    pub checks: usize,
    /// The failed checks, each in a few words.
    pub failures: Vec<String>,
}

impl Section {
    /// Counts a check of the section. If `holds` is false, the check has failed, and `failure` describes it in a few
    /// words.
    pub(crate) fn check(&mut self, holds: bool, failure: impl Into<String>) {
        self.checks += 1;
        if !holds {
            self.failures.push(failure.into());
        }
    }

    /// Returns the section, without its heading, as text for a terminal. `shown` converts an answer to text, for example
    /// with a colour.
    pub fn to_text(&self, shown: impl Fn(&Item) -> String) -> String {
        let answers = self.answers.iter().map(|answer| shown(answer) + "\n");
        self.text.clone() + &answers.collect::<String>()
    }

    fn to_json(&self) -> Value {
        json!({
            "title": self.title,
            "answers": self.answers,
            "checks": self.checks,
            "failures": self.failures,
            "tables": self.tables.iter().map(Table::to_json).collect::<Vec<_>>(),
        })
    }

    /// How many checks there are, and how many of them failed.
    fn outcome(&self) -> Item {
        let (checks, failed) = (self.checks, self.failures.len());
        let noun = if checks == 1 { "check" } else { "checks" };
        let level = if failed == 0 { Level::Good } else { Level::Bad };
        let title = &self.title;
        Item::limit(format!("{title}: {checks} {noun}, {failed} failed"), level)
    }

    fn to_html(&self) -> String {
        let mut html = format!("<h2>{}</h2>\n", escape(&self.title));
        let failed = |failure: &String| format!("<p>Failed: {}</p>\n", prose(failure));
        html.extend(self.failures.iter().map(failed));
        let note = |note: &String| format!("<p>{}</p>\n", prose(note));
        html.extend(self.notes.iter().map(note));
        html.extend(self.charts.iter().map(|chart| {
            let title = escape(&chart.title);
            format!("<canvas class=\"chart\" role=\"img\" aria-label=\"{title}\"></canvas>\n")
        }));
        for table in &self.tables {
            let (title, rows) = (prose(&table.title), table.to_html());
            html += &format!(
                "<details><summary>{title}</summary>\n<div class=\"wide\">{rows}</div></details>\n"
            );
        }
        html
    }
}

/// Returns a table as text for a terminal. A row with the scene's own settings begins with `*`, a failed row with `!`.
pub(crate) fn marked(table: &Table) -> String {
    let mark = |emphasis| match emphasis {
        Emphasis::Plain => ' ',
        Emphasis::Default => '*',
        Emphasis::Failed => '!',
    };
    let rows = table.rows.iter().map(|row| mark(row.emphasis));
    let mut lines = table.shown();
    for (line, mark) in lines.iter_mut().zip([' '].into_iter().chain(rows)) {
        line[0] = format!("{mark} {}", line[0]);
    }
    aligned(&lines)
}

/// The results of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// The heading.
    pub title: String,
    /// A few words that describe the case.
    pub subject: String,
    /// The sections.
    pub sections: Vec<Section>,
}

impl Sheet {
    /// Returns the failed checks as an error.
    ///
    /// # Errors
    /// [`Error::CheckFailed`] if a check failed.
    pub fn judge(&self) -> Result<()> {
        let failures = self.sections.iter().flat_map(|section| &section.failures);
        let failures: Vec<&str> = failures.map(String::as_str).collect();
        if failures.is_empty() {
            return Ok(());
        }
        Err(Error::CheckFailed {
            what: failures.join("; "),
            failed: failures.len(),
            total: self.sections.iter().map(|section| section.checks).sum(),
        })
    }

    /// Returns all results as JSON, except the charts.
    pub fn to_json(&self) -> Value {
        json!({
            "title": self.title,
            "subject": self.subject,
            "sections": self.sections.iter().map(Section::to_json).collect::<Vec<_>>(),
        })
    }

    /// The number of checks of every section, and how many of them failed, as text for a terminal. `shown` converts an
    /// answer to text, for example with a colour.
    pub fn outcomes(&self, shown: impl Fn(&Item) -> String) -> String {
        let sections = self.sections.iter();
        sections
            .map(|section| shown(&section.outcome()) + "\n")
            .collect()
    }

    /// Returns one HTML page that loads nothing from elsewhere.
    pub fn to_html(&self) -> String {
        let (title, subject) = (escape(&self.title), escape(&self.subject));
        let sections: String = self.sections.iter().map(Section::to_html).collect();
        let answers = self.sections.iter().flat_map(|section| &section.answers);
        let outcomes = self.sections.iter().map(Section::outcome);
        let answers = answers.cloned().chain(outcomes);
        let answer = |Item { text, level, .. }: Item| {
            format!("<li class=\"{}\">{}</li>\n", level.name(), escape(&text))
        };
        let answers: String = answers.map(answer).collect();
        let charts = self.sections.iter().flat_map(|section| &section.charts);
        let charts = json!(charts.collect::<Vec<_>>());
        let body = [
            STYLE,
            &format!("<h1>{title}</h1>\n<p class=\"muted\">{subject}</p>\n"),
            &format!("<ul class=\"answers\">\n{answers}</ul>\n{sections}"),
            "<p class=\"muted\">Blue rows have the scene's own settings. Red rows failed. Hover over a column's heading \
             for its meaning.</p>\n",
            &page::script(&charts, include_str!("page/check.js")),
        ];
        page::html(&self.title, &body.concat())
    }

    /// Writes `check.html` and a CSV file for every table into a folder, and returns the paths.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        make_folder(folder)?;
        let tables = self.sections.iter().flat_map(|section| &section.tables);
        let tables = tables.map(|table| (format!("{}.csv", table.name), table.to_csv()));
        let page = ("check.html".to_owned(), self.to_html());
        write_texts(folder, std::iter::once(page).chain(tables))
    }
}

/// The styles of the page: scrolling for wide tables, and colours for marked rows.
const STYLE: &str = "<style>.wide { overflow-x: auto; } .wide td, .wide th { padding-right: 18px; }\n\
    .chart { height: 340px; }\n\
    tr.default td { background: #eaf3fb; font-weight: 600; }\n\
    tr.failed td { background: #fdecea; color: #a3260b; }\n\
    @media screen and (prefers-color-scheme: dark) { tr.default td { background: #14304a; } tr.failed td { background: #45201b; color: #ffb4a8; } }\n\
    .answers { margin: 16px 0; padding: 12px 16px 12px 34px; background: var(--panel); border-radius: 8px; font-size: 17px; }</style>\n";
