//! Tables of typed columns, written as HTML, CSV, JSON and aligned text.
//!
//! A [`Table`] holds numbers and texts. Each [`Column`] has a meaning, a unit, and the number of digits that people
//! see. CSV and JSON keep every bit.

mod column;
mod fill;
mod grid;
mod words;

pub use column::{Cell, Column};
pub use fill::TableOf;
pub use grid::{Emphasis, Row, Table, aligned};
pub use words::{escape, prose};
