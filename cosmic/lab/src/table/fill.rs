//! Builds tables column by column.

use super::{Cell, Column, Emphasis, Row, Table};
use cosmic::keys::{Keyed, columns};

/// A table under construction, which has one row for each subject. A subject is any value from which the cells of its
/// row are computed.
pub struct TableOf<'a, S> {
    subjects: &'a [S],
    table: Table,
}

impl Table {
    /// Begins a table with an ordinary row for each subject. The methods `column` and `columns` add its columns.
    pub fn of<'a, S>(name: &str, title: &str, subjects: &'a [S]) -> TableOf<'a, S> {
        let table = Self {
            name: name.to_owned(),
            title: title.to_owned(),
            columns: Vec::new(),
            rows: vec![Row::default(); subjects.len()],
        };
        TableOf { subjects, table }
    }
}

impl<'a, S> TableOf<'a, S> {
    /// Adds a column. `name` is its heading, `says` describes it, and `cell` computes the cell of a subject.
    pub fn column<C: Into<Cell>>(self, name: &str, says: &str, cell: impl Fn(&'a S) -> C) -> Self {
        self.add(Column::new(name, says), cell)
    }

    /// Adds a described column. `cell` computes the cell of a subject.
    pub fn add<C: Into<Cell>>(mut self, column: Column, cell: impl Fn(&'a S) -> C) -> Self {
        self.table.columns.push(column);
        for (row, subject) in self.table.rows.iter_mut().zip(self.subjects) {
            row.cells.push(cell(subject).into());
        }
        self
    }

    /// Adds a column for each name. All these columns have the same description. `cell` computes a cell from the
    /// subject and the index of the name.
    pub fn columns<C: Into<Cell>>(
        mut self,
        names: impl IntoIterator<Item = impl AsRef<str>>,
        says: &str,
        cell: impl Fn(&'a S, usize) -> C,
    ) -> Self {
        for (k, name) in names.into_iter().enumerate() {
            self = self.column(name.as_ref(), says, |subject| cell(subject, k));
        }
        self
    }

    /// Adds the columns that a file declares. `of` returns the file of a subject, if it has one.
    pub fn keyed<K: Keyed>(mut self, of: impl Fn(&'a S) -> Option<K>) -> Self {
        let numbers = self
            .subjects
            .iter()
            .map(|subject| Some(of(subject)?.numbers()));
        let numbers: Vec<Option<Vec<Option<f64>>>> = numbers.collect();
        for (k, declared) in columns(&K::keys()).into_iter().enumerate() {
            self.table.columns.push(declared.into());
            for (row, numbers) in self.table.rows.iter_mut().zip(&numbers) {
                let number = numbers.as_ref().and_then(|numbers| numbers[k]);
                row.cells.push(number.into());
            }
        }
        self
    }

    /// Sets the decimals, and the text for missing numbers, of all columns added so far; see [`Column::decimals`].
    pub fn decimals(mut self, decimals: usize, missing: &'static str) -> Self {
        let columns = self.table.columns.into_iter();
        let columns = columns.map(|column| column.decimals(decimals, missing));
        self.table.columns = columns.collect();
        self
    }

    /// Sets the text for missing numbers, in tables for people, of all columns added so far.
    pub fn missing(mut self, missing: &'static str) -> Self {
        let columns = self.table.columns.iter_mut();
        columns.for_each(|column| column.missing = missing);
        self
    }

    /// Sets the decimals in CSV of all columns added so far; see [`Column::rounded`].
    pub fn rounded(mut self, decimals: usize) -> Self {
        let columns = self.table.columns.into_iter();
        self.table.columns = columns.map(|column| column.rounded(decimals)).collect();
        self
    }

    /// Emphasises the rows of all subjects for which `is` returns true. If a row is emphasised twice, the last call
    /// counts.
    pub fn mark(mut self, emphasis: Emphasis, is: impl Fn(&S) -> bool) -> Self {
        for (row, subject) in self.table.rows.iter_mut().zip(self.subjects) {
            if is(subject) {
                row.emphasis = emphasis;
            }
        }
        self
    }

    /// Returns the finished table.
    pub fn done(self) -> Table {
        self.table
    }
}
