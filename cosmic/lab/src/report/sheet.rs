//! Writes the tables and figures of a verification as an HTML page, as JSON, CSV and SVG files, and as text.

use super::chart::LogChart;
use super::page;
use crate::files::write_texts;
use crate::table::{Standing, Table, aligned, escape, prose};
use cosmic::error::{Error, Result};
use cosmic::record::files::{Format, make_folder, write_json};
use cosmic::verdict::{Item as Answer, Level};
use serde_json::{Value, json};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// The format of a sheet's JSON file.
pub const FORMAT: Format = Format {
    name: "cosmic-verification",
    version: 1,
};

/// A section of a sheet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// The heading.
    pub title: String,
    /// Answers in plain words, each with its level. They come before everything else.
    pub verdict: Vec<Answer>,
    /// Explanations that come before the tables. Each is a sentence or two.
    pub notes: Vec<String>,
    /// The tables. Each is also written as a file `name.csv`.
    pub tables: Vec<Table>,
    /// The charts. Each is also written as a file `name.svg`.
    pub figures: Vec<LogChart>,
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

    fn to_json(&self) -> Value {
        let table = |table: &Table| table.with_standings().to_json();
        json!({
            "title": self.title,
            "verdict": self.verdict,
            "notes": self.notes,
            "checks": self.checks,
            "failures": self.failures,
            "tables": self.tables.iter().map(table).collect::<Vec<_>>(),
        })
    }

    /// How many checks there are, and how many of them failed.
    fn outcome(&self) -> String {
        let (checks, failed) = (self.checks, self.failures.len());
        let noun = if checks == 1 { "check" } else { "checks" };
        format!("{checks} {noun}, {failed} failed")
    }

    fn to_text(&self) -> String {
        let mut text = format!("\n{}\n", self.title.to_uppercase());
        text.extend(self.notes.iter().map(|note| format!("- {note}\n")));
        for table in &self.tables {
            text += &format!("\n{}\n{}", table.title, marked(table));
        }
        text += &format!("\n{}\n", self.outcome());
        text.extend(self.failures.iter().map(|failure| format!("! {failure}\n")));
        text
    }

    fn to_html(&self) -> String {
        let mut html = format!(
            "<h2>{}</h2>\n<p><b>{}.</b></p>\n",
            escape(&self.title),
            self.outcome()
        );
        let failed = |failure: &String| format!("<p>Failed: {}</p>\n", prose(failure));
        html.extend(self.failures.iter().map(failed));
        let note = |note: &String| format!("<p>{}</p>\n", prose(note));
        html.extend(self.notes.iter().map(note));
        for figure in &self.figures {
            let (svg, caption) = (figure.draw(), prose(&figure.caption));
            html += &format!("{svg}<p class=\"muted\">{caption}</p>\n");
        }
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
fn marked(table: &Table) -> String {
    let mark = |standing| match standing {
        Standing::Plain => ' ',
        Standing::Default => '*',
        Standing::Failed => '!',
    };
    let rows = table.rows.iter().map(|row| mark(row.standing));
    let mut lines = table.shown();
    for (line, mark) in lines.iter_mut().zip([' '].into_iter().chain(rows)) {
        line[0] = format!("{mark} {}", line[0]);
    }
    aligned(&lines)
}

/// The results of a verification.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// The heading.
    pub title: String,
    /// A sentence that describes the case.
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

    /// The verdict of all sections: their answers, and for each section whether its checks hold.
    fn verdict(&self) -> Vec<Answer> {
        let answers = self.sections.iter().flat_map(|section| &section.verdict);
        let checks = |section: &Section| {
            let level = match section.failures.is_empty() {
                true => Level::Good,
                false => Level::Bad,
            };
            Answer::limit(format!("{}: {}", section.title, section.outcome()), level)
        };
        let checks = self.sections.iter().map(checks);
        answers.cloned().chain(checks).collect()
    }

    /// Returns the verdict as text for a terminal, a line for each answer. `shown` converts an answer to text, for example
    /// with a colour.
    pub fn verdict_text(&self, shown: impl Fn(&Answer) -> String) -> String {
        let lines = self.verdict();
        let lines = lines.iter().map(|answer| format!("{}\n", shown(answer)));
        let failures = self.sections.iter().flat_map(|section| &section.failures);
        let failures = failures.map(|failure| format!("! {failure}\n"));
        let lines: String = lines.chain(failures).collect();
        format!("{}: {}\n\n{lines}", self.title, self.subject)
    }

    /// Returns the verdict, the notes and the tables as text for a terminal. A row with the scene's own settings begins
    /// with `*`, a failed row with `!`.
    pub fn to_text(&self) -> String {
        let sections: String = self.sections.iter().map(Section::to_text).collect();
        self.verdict_text(|answer| answer.text.clone()) + &sections
    }

    /// Returns one HTML page that loads nothing from elsewhere.
    pub fn to_html(&self) -> String {
        let (title, subject) = (escape(&self.title), escape(&self.subject));
        let sections: String = self.sections.iter().map(Section::to_html).collect();
        let answer = |Answer { text, level, .. }: &Answer| {
            format!("<li class=\"{}\">{}</li>\n", level.name(), escape(text))
        };
        let answers: String = self.verdict().iter().map(answer).collect();
        let verdict = format!("<ul class=\"answers\">\n{answers}</ul>\n");
        let body = format!(
            "{STYLE}<h1>{title}</h1>\n<p class=\"muted\">{subject}</p>\n{verdict}{sections}<p \
             class=\"muted\">Blue rows have the scene's own settings. Red rows failed. Hover over a \
             column's heading for its meaning.</p>\n"
        );
        page::html(&self.title, &body)
    }

    /// Writes `verify.html`, `verify.json`, a CSV file for every table and an SVG file for every chart into a folder,
    /// and returns the paths. A table that is in several sections is written once.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        make_folder(folder)?;
        let mut texts = vec![("verify.html".to_owned(), self.to_html())];
        for section in &self.sections {
            let csv = |table: &Table| table.with_standings().to_csv();
            let tables = section.tables.iter();
            texts.extend(tables.map(|t| (format!("{}.csv", t.name), csv(t))));
            let figures = section.figures.iter();
            texts.extend(figures.map(|f| (format!("{}.svg", f.name), f.draw())));
        }
        let mut seen = HashSet::new();
        texts.retain(|text| seen.insert(text.clone()));
        let json = folder.join("verify.json");
        write_json(&json, FORMAT, &self.to_json())?;
        let mut written = vec![json];
        written.extend(write_texts(folder, texts)?);
        Ok(written)
    }
}

/// The styles of the page: scrolling for wide tables, and colours for marked rows.
const STYLE: &str = "<style>.wide { overflow-x: auto; } .wide td, .wide th { padding-right: 18px; }\n\
    tr.default td { background: #eaf3fb; font-weight: 600; }\n\
    tr.failed td { background: #fdecea; color: #a3260b; }\n\
    @media screen and (prefers-color-scheme: dark) { tr.default td { background: #14304a; } tr.failed td { background: #45201b; color: #ffb4a8; } }\n\
    .answers { margin: 16px 0; padding: 12px 16px 12px 34px; background: var(--panel); border-radius: 8px; font-size: 17px; }</style>\n";
