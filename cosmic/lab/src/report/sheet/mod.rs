//! Sheets: the tables and figures of a check as one page, JSON, CSV and SVG files, and as text.

mod page;
mod text;

pub(super) use text::aligned;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use cosmic::error::{Error, Result};
use cosmic::record::files::{Format, csv_cell, make_folder, write_atomic, write_json};

/// What a sheet's JSON file says it is.
pub const FORMAT: Format = Format {
    name: "cosmic-verification",
    version: 1,
};

/// One number, or what stands in its place.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A whole number.
    Count(usize),
    /// A number; one that is not finite is shown as failed.
    Number(f64),
    /// Nothing was measured here.
    Missing,
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Cell::Missing, Cell::Number)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_owned())
    }
}

impl Cell {
    /// A number, or none where there is no finite one.
    pub(crate) fn if_finite(number: f64) -> Self {
        Some(number).filter(|x| x.is_finite()).into()
    }

    /// As JSON has it: numbers to the last bit, those that are not finite as `null`.
    fn to_json(&self) -> Value {
        match self {
            Cell::Text(text) => json!(text),
            Cell::Count(count) => json!(count),
            Cell::Number(number) => json!(number),
            Cell::Missing => Value::Null,
        }
    }
}

/// How a row stands out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Standing {
    /// It does not.
    #[default]
    Plain,
    /// What the scene itself asks for.
    Default,
    /// It failed.
    Failed,
}

/// A row of a [`Table`].
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// One for each column.
    pub cells: Vec<Cell>,
    /// How it stands out.
    pub standing: Standing,
}

/// What stands at the head of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its key in JSON and CSV, and its heading.
    pub name: String,
    /// What it is, with its unit.
    pub says: String,
}

impl Column {
    /// A column of this name and meaning.
    pub fn new(name: &str, says: &str) -> Self {
        let [name, says] = [name, says].map(str::to_owned);
        Self { name, says }
    }
}

/// A table, in a file `name.csv` of its own as well.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Its file's name.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// What its columns are.
    pub columns: Vec<Column>,
    /// Its rows.
    pub rows: Vec<Row>,
}

impl Table {
    /// The table as CSV: numbers to the last bit, the standing of a row in the last column.
    pub fn to_csv(&self) -> String {
        let cell = |cell: &Cell| match cell {
            Cell::Text(text) => csv_cell(text),
            Cell::Count(count) => count.to_string(),
            Cell::Number(number) => format!("{number:e}"),
            Cell::Missing => String::new(),
        };
        let head = self.columns.iter().map(|column| csv_cell(&column.name));
        let mut lines = vec![head.chain([STANDING.to_owned()]).collect::<Vec<_>>()];
        for row in &self.rows {
            let standing = standing_name(row.standing).to_owned();
            lines.push(row.cells.iter().map(cell).chain([standing]).collect());
        }
        lines.iter().map(|line| line.join(",") + "\n").collect()
    }

    fn to_json(&self) -> Value {
        let row = |row: &Row| {
            let keys = self.columns.iter().map(|column| column.name.clone());
            let mut object: Map<String, Value> =
                keys.zip(row.cells.iter().map(Cell::to_json)).collect();
            object.insert(STANDING.to_owned(), json!(standing_name(row.standing)));
            Value::Object(object)
        };
        let says = |column: &Column| (column.name.clone(), json!(column.says));
        let standing = (STANDING.to_owned(), json!(STANDING_SAYS));
        json!({
            "name": self.name,
            "title": self.title,
            "columns": self.columns.iter().map(says).chain([standing]).collect::<Map<_, _>>(),
            "rows": self.rows.iter().map(row).collect::<Vec<_>>(),
        })
    }
}

/// The last column of every table.
const STANDING: &str = "standing";
/// What it is.
const STANDING_SAYS: &str =
    "how the row stands out: plain, default (what the scene itself asks for) or failed";

fn standing_name(standing: Standing) -> &'static str {
    match standing {
        Standing::Plain => "plain",
        Standing::Default => "default",
        Standing::Failed => "failed",
    }
}

/// A picture, in a file `name.svg` of its own as well.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its file's name.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The picture.
    pub svg: String,
}

/// One subject of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What is to be known before its tables are read, a sentence or two each.
    pub notes: Vec<String>,
    /// Its tables.
    pub tables: Vec<Table>,
    /// Its pictures.
    pub figures: Vec<Figure>,
    /// How many checks were made.
    pub checks: usize,
    /// Those that failed, each in a few words.
    pub failures: Vec<String>,
}

/// All that a verification found.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Its heading.
    pub title: String,
    /// What it was made of and on, in a sentence.
    pub subject: String,
    /// One for each subject.
    pub sections: Vec<Section>,
}

impl Sheet {
    /// An error where a check failed.
    ///
    /// # Errors
    /// [`Error::CheckFailed`].
    pub fn judge(&self) -> Result<()> {
        let failures: Vec<&str> = self
            .sections
            .iter()
            .flat_map(|section| section.failures.iter().map(String::as_str))
            .collect();
        if failures.is_empty() {
            return Ok(());
        }
        Err(Error::CheckFailed {
            what: failures.join("; "),
            failed: failures.len(),
            total: self.sections.iter().map(|section| section.checks).sum(),
        })
    }

    /// Everything but the pictures.
    pub fn to_json(&self) -> Value {
        let section = |section: &Section| {
            json!({
                "title": section.title,
                "notes": section.notes,
                "checks": section.checks,
                "failures": section.failures,
                "tables": section.tables.iter().map(Table::to_json).collect::<Vec<_>>(),
            })
        };
        json!({
            "title": self.title,
            "subject": self.subject,
            "sections": self.sections.iter().map(section).collect::<Vec<_>>(),
        })
    }

    /// Writes `verify.html`, `verify.json`, a CSV file for every table and an SVG file for every
    /// figure straight into a folder, and says which files these are. A table that several sections
    /// have is one file.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        make_folder(folder)?;
        let mut texts = vec![("verify.html".to_owned(), page::render(self))];
        for section in &self.sections {
            let tables = section.tables.iter();
            texts.extend(tables.map(|t| (format!("{}.csv", t.name), t.to_csv())));
            let figures = section.figures.iter();
            texts.extend(figures.map(|f| (format!("{}.svg", f.name), f.svg.clone())));
        }
        let mut seen = HashSet::new();
        texts.retain(|text| seen.insert(text.clone()));
        let json = folder.join("verify.json");
        write_json(&json, FORMAT, &self.to_json())?;
        let mut written = vec![json];
        for (name, text) in texts {
            let path = folder.join(name);
            write_atomic(&path, |file| file.write_all(text.as_bytes()))?;
            written.push(path);
        }
        Ok(written)
    }
}

#[cfg(test)]
mod tests {
    use super::{Cell, Column, Row, Section, Sheet, Standing, Table};

    fn sheet() -> Sheet {
        let row = |cells: [Cell; 3], standing| Row {
            cells: cells.to_vec(),
            standing,
        };
        let table = Table {
            name: "errors".to_owned(),
            title: "Errors".to_owned(),
            columns: vec![
                Column::new("method", "what was done"),
                Column::new("steps", "how many"),
                Column::new("error", "m"),
            ],
            rows: vec![
                row(
                    ["one, <two>".into(), Cell::Count(3), Cell::Number(0.1 + 0.2)],
                    Standing::Default,
                ),
                row(
                    ["none".into(), Cell::Missing, Cell::Number(f64::NAN)],
                    Standing::Failed,
                ),
            ],
        };
        Sheet {
            title: "T".to_owned(),
            subject: "s".to_owned(),
            sections: vec![Section {
                title: "A & B".to_owned(),
                notes: vec!["Read this.".to_owned()],
                tables: vec![table],
                figures: Vec::new(),
                checks: 2,
                failures: vec!["none".to_owned()],
            }],
        }
    }

    #[test]
    fn csv_keeps_every_digit_and_quotes() {
        assert_eq!(
            sheet().sections[0].tables[0].to_csv(),
            "method,steps,error,standing\n\
             \"one, <two>\",3,3.0000000000000004e-1,default\n\
             none,,NaN,failed\n"
        );
    }

    #[test]
    fn json_names_the_numbers() {
        let json = sheet().to_json();
        let rows = &json["sections"][0]["tables"][0]["rows"];
        assert_eq!(rows[0]["error"], 0.1 + 0.2);
        assert_eq!(rows[0]["standing"], "default");
        assert!(rows[1]["error"].is_null() && rows[1]["steps"].is_null());
        let columns = json["sections"][0]["tables"][0]["columns"].as_object();
        assert!(
            columns
                .unwrap()
                .keys()
                .eq(rows[0].as_object().unwrap().keys())
        );
    }

    #[test]
    fn a_failed_row_is_seen_on_the_page_and_in_text() {
        let page = super::page::render(&sheet());
        assert!(page.contains("<tr class=\"failed\">") && page.contains("one, &lt;two&gt;"));
        let text = sheet().to_text();
        let line = |word: &str| text.lines().find(|line| line.contains(word)).unwrap();
        assert!(line("none").starts_with("! ") && line("<two>").starts_with("* "));
    }

    #[test]
    fn a_table_that_sections_share_is_written_once() {
        let mut sheet = sheet();
        sheet.sections.push(sheet.sections[0].clone());
        let folder = tempfile::tempdir().unwrap();
        let written = sheet.write(folder.path()).unwrap();
        let names = ["verify.json", "verify.html", "errors.csv"];
        assert_eq!(written, names.map(|name| folder.path().join(name)));
    }

    #[test]
    fn a_failure_is_an_error_with_its_count() {
        let error = sheet().judge().unwrap_err();
        assert_eq!(error.to_string(), "1 of 2 checks failed: none");
        let mut sheet = sheet();
        sheet.sections[0].failures.clear();
        sheet.judge().unwrap();
    }
}
