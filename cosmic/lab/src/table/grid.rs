//! Tables, which can be written as CSV, JSON, HTML and text.

use super::words::{escape, prose, quoted};
use super::{Cell, Column};
use serde_json::{Map, Value, json};
use std::fmt::Write;

/// The emphasis of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Emphasis {
    /// An ordinary row, without emphasis.
    #[default]
    Plain,
    /// The row with the scene's own settings.
    Default,
    /// A row that failed its check.
    Failed,
}

impl Emphasis {
    /// The name of the emphasis in files and style sheets.
    fn name(self) -> &'static str {
        match self {
            Emphasis::Plain => "plain",
            Emphasis::Default => "default",
            Emphasis::Failed => "failed",
        }
    }
}

/// A row of a [`Table`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// A cell for each column.
    pub cells: Vec<Cell>,
    /// The emphasis of the row.
    pub emphasis: Emphasis,
}

/// A table: rows of cells under named columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The name of the file that the table is written to, without extension; may be empty.
    pub name: String,
    /// The heading of the table; may be empty.
    pub title: String,
    /// The columns.
    pub columns: Vec<Column>,
    /// The rows.
    pub rows: Vec<Row>,
}

impl Table {
    /// This table without the columns in which no row has a value.
    #[must_use]
    pub fn without_empty(self) -> Self {
        let is_used = |k: &usize| self.rows.iter().any(|row| row.cells[*k] != Cell::Missing);
        let used: Vec<usize> = (0..self.columns.len()).filter(is_used).collect();
        let row = |Row { cells, emphasis }: Row| Row {
            cells: used.iter().map(|&k| cells[k].clone()).collect(),
            emphasis,
        };
        Self {
            columns: used.iter().map(|&k| self.columns[k].clone()).collect(),
            rows: self.rows.into_iter().map(row).collect(),
            ..self
        }
    }

    /// The table as CSV: a line of names, then a line for each row.
    pub fn to_csv(&self) -> String {
        let head = self.columns.iter().map(|column| quoted(&column.name));
        let rows = self.rows.iter().map(|row| self.written(row, Column::csv));
        let lines = std::iter::once(head.collect()).chain(rows);
        lines.map(|line: Vec<_>| line.join(",") + "\n").collect()
    }

    /// The table as JSON: an object with the description of every column, by the column's name, and with a list of the
    /// rows. Each row is an object whose keys are the names of the columns.
    pub fn to_json(&self) -> Value {
        let row = |row: &Row| {
            let cells = self.columns.iter().zip(&row.cells);
            let pairs = cells.map(|(column, cell)| (column.name.clone(), json!(cell)));
            Value::Object(pairs.collect())
        };
        let says = |column: &Column| (column.name.clone(), json!(column.says));
        json!({
            "name": self.name,
            "title": self.title,
            "columns": self.columns.iter().map(says).collect::<Map<_, _>>(),
            "rows": self.rows.iter().map(row).collect::<Vec<_>>(),
        })
    }

    /// The table as HTML. The description of a column appears when the mouse rests on its heading.
    pub fn to_html(&self) -> String {
        let mut html = String::from("<table>");
        let named = self.columns.iter().any(|column| !column.name.is_empty());
        if named {
            let head = |column: &Column| {
                let says = escape(&column.says.replace('`', ""));
                format!("<th title=\"{says}\">{}</th>", escape(&column.heading()))
            };
            let heads: String = self.columns.iter().map(head).collect();
            html += &format!("<thead><tr>{heads}</tr></thead>");
        }
        html += "<tbody>\n";
        for row in &self.rows {
            html += &match row.emphasis {
                Emphasis::Plain => "<tr>".to_owned(),
                emphasis => format!("<tr class=\"{}\">", emphasis.name()),
            };
            for (column, cell) in self.columns.iter().zip(&row.cells) {
                let class = match cell {
                    Cell::Text(_) => "",
                    _ => " class=\"number\"",
                };
                html += &format!("<td{class}>{}</td>", prose(&column.shown(cell)));
            }
            html += "</tr>\n";
        }
        html + "</tbody></table>\n"
    }

    /// The table as text for a terminal; see [`aligned`].
    pub fn to_text(&self) -> String {
        aligned(&self.shown())
    }

    /// All cells of the table as texts for people. The first line has the headings; then there is a line for each row.
    pub(crate) fn shown(&self) -> Vec<Vec<String>> {
        let head = self.columns.iter().map(Column::heading).collect();
        let rows = self.rows.iter().map(|row| self.written(row, Column::shown));
        std::iter::once(head).chain(rows).collect()
    }

    fn written(&self, row: &Row, write: fn(&Column, &Cell) -> String) -> Vec<String> {
        let cells = self.columns.iter().zip(&row.cells);
        cells.map(|(column, cell)| write(column, cell)).collect()
    }
}

/// Aligns lines of cells in columns: the first column is left-aligned, the others are right-aligned. All lines must
/// have equally many cells.
pub fn aligned(lines: &[Vec<String>]) -> String {
    let width = |k: usize| lines.iter().map(|cells| cells[k].chars().count()).max();
    let columns = lines.first().map_or(0, Vec::len);
    let widths: Vec<usize> = (0..columns).map(|k| width(k).unwrap_or(0)).collect();
    let mut text = String::new();
    for cells in lines {
        let mut line = format!("{:w$}", cells[0], w = widths[0]);
        for (cell, w) in cells.iter().zip(&widths).skip(1) {
            // Writing to a string cannot fail.
            let _ = write!(line, "  {cell:>w$}");
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}
