//! A sheet for a terminal.

use std::fmt::Write;

use super::{Cell, Section, Sheet, Standing, Table};

impl Sheet {
    /// Notes and tables, aligned. A row of the scene's own settings begins with `*`, a failed one
    /// with `!`.
    pub fn to_text(&self) -> String {
        let sections: String = self.sections.iter().map(section).collect();
        format!("{}: {}\n{sections}", self.title, self.subject)
    }
}

fn section(section: &Section) -> String {
    let mut text = format!("\n{}\n", section.title.to_uppercase());
    for note in &section.notes {
        // Writing to a string cannot fail, here and below.
        let _ = writeln!(text, "- {note}");
    }
    for table in &section.tables {
        let _ = write!(text, "\n{}\n{}", table.title, of_table(table));
    }
    let failed = section.failures.len();
    let _ = writeln!(text, "\n{} checks, {failed} failed", section.checks);
    for failure in &section.failures {
        let _ = writeln!(text, "! {failure}");
    }
    text
}

fn of_table(table: &Table) -> String {
    let marked = |mark: char, cells: &mut dyn Iterator<Item = String>| {
        let mut cells: Vec<String> = cells.collect();
        cells[0] = format!("{mark} {}", cells[0]);
        cells
    };
    let mut head = table.columns.iter().map(|column| column.name.clone());
    let mut lines = vec![marked(' ', &mut head)];
    for row in &table.rows {
        let mark = match row.standing {
            Standing::Plain => ' ',
            Standing::Default => '*',
            Standing::Failed => '!',
        };
        lines.push(marked(mark, &mut row.cells.iter().map(shown)));
    }
    aligned(&lines)
}

/// Lines of as many cells each in columns: the first to the left, the others to the right.
pub(in crate::report) fn aligned(lines: &[Vec<String>]) -> String {
    let width = |k: usize| lines.iter().map(|cells| cells[k].chars().count()).max();
    let columns = lines.first().map_or(0, Vec::len);
    let widths: Vec<usize> = (0..columns).map(|k| width(k).unwrap_or(0)).collect();
    let mut text = String::new();
    for cells in lines {
        let mut line = format!("{:w$}", cells[0], w = widths[0]);
        for (cell, w) in cells.iter().zip(&widths).skip(1) {
            let _ = write!(line, "  {cell:>w$}");
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// A cell as people read it: three digits of a number.
pub(super) fn shown(cell: &Cell) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Count(count) => count.to_string(),
        Cell::Missing => "-".to_owned(),
        Cell::Number(0.0) => "0".to_owned(),
        Cell::Number(x) if !x.is_finite() => "failed".to_owned(),
        Cell::Number(x) if (0.01..1e4).contains(&x.abs()) => {
            let digits = 2 - x.abs().log10().floor() as i32;
            let text = format!("{x:.*}", digits.max(0) as usize);
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        }
        Cell::Number(x) => format!("{x:.1e}"),
    }
}
