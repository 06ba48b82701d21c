//! Formats the tables of instruction counts.

use crate::works::CountTable;

/// Returns all tables as text. `counts` has the counts of all works, in order.
pub(crate) fn page(tables: &[CountTable], counts: &[f64], valgrind: &str) -> String {
    let mut page = format!(
        "Counted by callgrind ({valgrind}) on AVX2 lanes. Each count is the difference between two \
         processes, of which one does the work once and the other more often. So it includes neither \
         the start of the program nor the setup.\n"
    );
    let mut counts = counts.iter().copied();
    for table in tables {
        page += &table_of(table, &mut counts);
    }
    page
}

fn table_of(table: &CountTable, counts: &mut impl Iterator<Item = f64>) -> String {
    let CountTable {
        title,
        about,
        columns,
        ..
    } = table;
    let mut text = format!("\n### {title}\n\n{about}\n\n| {} |\n", columns.join(" | "));
    text += &format!("|{}\n", " --- |".repeat(columns.len()));
    let mut base = None;
    for (name, works) in &table.rows {
        text += &format!("| {name} |");
        for count in counts.by_ref().take(works.len()) {
            let times = count / *base.get_or_insert(count);
            text += &format!(" {count:.0} ({times:.2}) |");
        }
        // If a row has fewer works than the table has columns, empty cells are added.
        text += &" |".repeat(columns.len() - 1 - works.len());
        text.push('\n');
    }
    text
}
