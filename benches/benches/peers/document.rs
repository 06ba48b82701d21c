//! Formats the tables of measured tasks.

use std::fmt::Write as _;

use crate::task::{Outcome, Task};

/// A task, with the measured times of each way to do it.
pub(crate) type Measured = (Task, Vec<Outcome>);

/// Returns the table of a task, with a row for each way to do it.
pub(crate) fn table((task, outcomes): &Measured) -> String {
    let mut table = format!(
        "### {}\n\n{}\n\n| by | how | us | ratio | lines |\n| --- | --- | --- | --- | --- |\n",
        task.title, task.about
    );
    for way in outcomes {
        let (us, ratio) = (way.seconds * 1e6, way.seconds / outcomes[0].seconds);
        let cells = format!("{us:.1} | {ratio:.1} | {}", way.lines);
        let _ = writeln!(table, "| {} | {} | {cells} |", way.by, way.how);
    }
    table
}

/// Returns the fastest way to do the task with this project's crate, and the fastest way with another crate.
fn fastest(outcomes: &[Outcome]) -> (&Outcome, Option<&Outcome>) {
    let least = |ours: bool| {
        let some = outcomes[1..]
            .iter()
            .filter(|way| (way.by == "ours") == ours);
        some.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    };
    (
        least(true).expect("every task has a way that uses this project's crate"),
        least(false),
    )
}

/// Returns a table with a row for each task: its fastest way with this project's crate, and its fastest way with
/// another crate.
pub(crate) fn summary(measured: &[Measured]) -> String {
    let mut table = String::from(
        "| task | ours, us | ratio to the reference | fastest peer | peer, us | peer's ratio to ours | lines, ours and \
         peer's |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (task, outcomes) in measured {
        let (ours, peer) = fastest(outcomes);
        let first = &outcomes[0];
        let own = ours.seconds / first.seconds;
        let _ = write!(
            table,
            "| {} | {:.1} | {own:.1} times {} | ",
            task.title,
            ours.seconds * 1e6,
            first.by
        );
        let _ = match peer {
            Some(peer) => writeln!(
                table,
                "{}, {} | {:.1} | {:.2} | {}, {} |",
                peer.by,
                peer.how,
                peer.seconds * 1e6,
                peer.seconds / ours.seconds,
                ours.lines,
                peer.lines
            ),
            None => writeln!(table, "none in this build | | | {} |", ours.lines),
        };
    }
    table
}
