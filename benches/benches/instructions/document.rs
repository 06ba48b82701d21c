//! The page `docs/instructions.md`.

use crate::works::{ComparedTo, CountTable};

/// The page, from the counts of all works in order.
pub(crate) fn page(tables: &[CountTable], counts: &[f64], valgrind: &str) -> String {
    let mut page = format!(
        "# Instructions\n\n\
         What [speed.md](speed.md) and [adbench.md](adbench.md) time, in instructions: a busy \
         machine counts the same as a quiet one, and two runs of a program agree to the last \
         instruction. Counted by callgrind ({valgrind}) on AVX2 lanes: valgrind knows no AVX-512, \
         with which it is less. Each count is the difference of two processes that do the work \
         once and more often, so that neither start nor setup is in it. Instructions are not \
         time: they tell whether a change made more work, not whether memory waits. This page is \
         written by\n\n```sh\n\
         cargo bench -p benches --bench instructions -- --table\n```\n"
    );
    let mut counts = counts.iter().copied();
    for table in tables {
        page += &section(table, &mut counts);
    }
    page
}

fn section(table: &CountTable, counts: &mut impl Iterator<Item = f64>) -> String {
    let CountTable {
        title,
        about,
        columns,
        ..
    } = table;
    let mut text = format!("\n## {title}\n\n{about}\n\n| {} |\n", columns.join(" | "));
    text += &format!("|{}\n", " --- |".repeat(columns.len()));
    let mut base = None;
    for (name, works) in &table.rows {
        text += &format!("| {name} |");
        if table.base == ComparedTo::Row {
            base = None;
        }
        for count in counts.by_ref().take(works.len()) {
            let times = count / *base.get_or_insert(count);
            text += &format!(" {count:.0} ({times:.2}) |");
        }
        // A row may end before the table does.
        text += &" |".repeat(columns.len() - 1 - works.len());
        text.push('\n');
    }
    text
}
