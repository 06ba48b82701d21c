//! The tables, and the page `docs/peers.md`.

use std::fmt::Write as _;

use benches::machine::machine;

use crate::task::{Outcome, Task};

/// A task with its table.
pub(crate) fn table(task: &Task, outcomes: &[Outcome]) -> String {
    let mut table = format!(
        "### {}\n\n{}\n\n| by | how | us | ratio | lines |\n| --- | --- | --- | --- | --- |\n",
        task.title, task.about
    );
    for way in outcomes {
        let _ = writeln!(
            table,
            "| {} | {} | {:.1} | {:.1} | {} |",
            way.by,
            way.how,
            way.seconds * 1e6,
            way.seconds / outcomes[0].seconds,
            way.lines
        );
    }
    table
}

pub(crate) fn page(measured: &[(Task, Vec<Outcome>)]) -> String {
    let tables = measured
        .iter()
        .map(|(task, outcomes)| table(task, outcomes));
    format!(
        "# Peers\n\nMeasured on {}\n\n{}",
        machine(),
        tables.collect::<Vec<_>>().join("\n")
    )
}
