//! What a column holds, and how its numbers are written.

use super::words::{decimals, quoted, three_digits};
use serde::Serialize;

/// A value of a table. JSON has numbers to the last bit, those that are not finite as `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A whole number.
    Count(u64),
    /// A number. People read "failed" where it is not finite.
    Number(f64),
    /// Nothing was measured here.
    Missing,
}

impl Cell {
    /// The number, or [`Cell::Missing`] where it is not finite.
    pub fn if_finite(number: f64) -> Self {
        Some(number).filter(|x| x.is_finite()).into()
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

/// The head of a column.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its key in JSON and CSV, and its heading.
    pub name: String,
    /// What it is, with its unit where there is no `unit`.
    pub says: String,
    /// The unit of its numbers, or nothing: in its heading, after the name.
    pub unit: &'static str,
    /// How many decimals people read; three digits without.
    decimals: Option<usize>,
    /// What people read where there is no number.
    missing: &'static str,
}

impl Column {
    /// A column of this name and meaning. People read three digits of its numbers.
    pub fn new(name: &str, says: &str) -> Self {
        Self {
            name: name.to_owned(),
            says: says.to_owned(),
            unit: "",
            decimals: None,
            missing: "-",
        }
    }

    /// People read so many decimals of its numbers, and a word where there is none.
    pub fn decimals(self, decimals: usize, missing: &'static str) -> Self {
        let decimals = Some(decimals);
        Self {
            decimals,
            missing,
            ..self
        }
    }

    /// Its numbers have a unit.
    pub fn unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The name, and the unit where there is one.
    pub fn heading(&self) -> String {
        match self.unit {
            "" => self.name.clone(),
            unit => format!("{}, {unit}", self.name),
        }
    }

    /// A cell as people read it.
    pub fn shown(&self, cell: &Cell) -> String {
        match (cell, self.decimals) {
            (Cell::Text(text), _) => text.clone(),
            (Cell::Count(count), _) => count.to_string(),
            (Cell::Missing, _) => self.missing.to_owned(),
            (Cell::Number(x), Some(places)) => decimals(*x, places),
            (Cell::Number(x), None) => three_digits(*x),
        }
    }

    /// A cell as people read it, with its unit where it is a number.
    pub fn shown_with_unit(&self, cell: &Cell) -> String {
        let shown = self.shown(cell);
        match (cell, self.unit) {
            (Cell::Text(_) | Cell::Missing, _) | (_, "") => shown,
            (_, unit) => format!("{shown} {unit}"),
        }
    }

    /// A cell as CSV has it: numbers to the last bit.
    pub(super) fn csv(&self, cell: &Cell) -> String {
        match (cell, self.decimals) {
            (Cell::Text(text), _) => quoted(text),
            (Cell::Count(count), _) => count.to_string(),
            (Cell::Missing, _) => String::new(),
            (Cell::Number(x), Some(_)) => x.to_string(),
            // Of any magnitude: without an exponent some would be hundreds of digits long.
            (Cell::Number(x), None) => format!("{x:e}"),
        }
    }
}
