//! The cells and columns of tables, and how their numbers are formatted.

use super::words::quoted;
use cosmic::keys::KeyColumn;
use cosmic::numbers::{finite, fixed, plain, short};
use serde::Serialize;

/// The content of one cell of a table. In JSON, a number keeps every bit; a number that is not finite becomes `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// A text in a cell.
    Text(String),
    /// A whole number in a cell.
    Count(u64),
    /// A number in a cell. A number that is not finite is shown as "diverged".
    Number(f64),
    /// A value that was not measured.
    Missing,
}

impl Cell {
    /// A cell with this number, or [`Cell::Missing`] if the number is not finite.
    pub fn if_finite(number: f64) -> Self {
        finite(number).into()
    }
}

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        Cell::Number(number)
    }
}

impl From<Option<f64>> for Cell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Cell::Missing, Cell::Number)
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Cell::Count(count as u64)
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.to_owned())
    }
}

impl From<Option<&str>> for Cell {
    fn from(text: Option<&str>) -> Self {
        text.map_or(Cell::Missing, Cell::from)
    }
}

/// The description of a column: its heading, its meaning, and how its numbers are formatted.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// The heading, which is also the key in JSON and CSV.
    pub name: String,
    /// A description of the column's meaning. If `unit` is empty, it also states the unit.
    pub says: String,
    /// The unit of the numbers, shown in the heading after the name; may be empty.
    pub unit: &'static str,
    /// The number of decimals in tables for people; `None` for three significant digits.
    decimals: Option<usize>,
    /// The text that tables for people show for a missing number.
    pub(super) missing: &'static str,
    /// The largest number of decimals in CSV; `None` keeps every bit.
    rounded: Option<usize>,
}

impl Column {
    /// A column whose numbers are shown to three significant digits.
    pub fn new(name: &str, says: &str) -> Self {
        Self {
            name: name.to_owned(),
            says: says.to_owned(),
            unit: "",
            decimals: None,
            missing: "-",
            rounded: None,
        }
    }

    /// Limits the number of decimals in CSV, and writes no exponents. Some programs cannot read exponents, and people
    /// copy the numbers by hand.
    pub fn rounded(mut self, decimals: usize) -> Self {
        self.rounded = Some(decimals);
        self
    }

    /// Sets the number of decimals, and the text for a missing number, in tables for people.
    pub fn decimals(mut self, decimals: usize, missing: &'static str) -> Self {
        (self.decimals, self.missing) = (Some(decimals), missing);
        self
    }

    /// Sets the unit of the numbers.
    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The heading as people see it: the name, followed by the unit if there is one.
    pub fn heading(&self) -> String {
        match self.unit {
            "" => self.name.clone(),
            unit => format!("{}, {unit}", self.name),
        }
    }

    /// The text of a cell in a table for people.
    pub fn shown(&self, cell: &Cell) -> String {
        match (cell, self.decimals) {
            (Cell::Text(text), _) => text.clone(),
            (Cell::Count(count), _) => count.to_string(),
            (Cell::Missing, _) => self.missing.to_owned(),
            (Cell::Number(x), _) if !x.is_finite() => "diverged".to_owned(),
            (Cell::Number(x), Some(places)) => fixed(*x, places),
            (Cell::Number(x), None) => short(*x),
        }
    }

    /// The text of a cell for people, with the unit after a number.
    pub fn shown_with_unit(&self, cell: &Cell) -> String {
        let shown = self.shown(cell);
        match (cell, self.unit) {
            (Cell::Text(_) | Cell::Missing, _) | (_, "") => shown,
            (_, unit) => format!("{shown} {unit}"),
        }
    }

    /// The text of a cell in CSV. Numbers keep every bit, unless the column is [rounded](Self::rounded).
    pub(super) fn csv(&self, cell: &Cell) -> String {
        match (cell, self.rounded) {
            (Cell::Text(text), _) => quoted(text),
            (Cell::Count(count), _) => count.to_string(),
            (Cell::Missing, _) => String::new(),
            (Cell::Number(x), Some(places)) => plain(*x, places),
            (Cell::Number(x), None) if *x == 0.0 || (1e-4..1e15).contains(&x.abs()) => {
                x.to_string()
            }
            // Without an exponent, a very large or small number would have hundreds of digits.
            (Cell::Number(x), None) => format!("{x:e}"),
        }
    }
}

impl From<KeyColumn> for Column {
    fn from(declared: KeyColumn) -> Self {
        let column = Self::new(declared.name, declared.says).unit(declared.unit);
        column.decimals(declared.decimals, "\u{2013}")
    }
}
