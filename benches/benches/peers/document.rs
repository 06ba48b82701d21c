//! The tables, and the page `docs/peers.md`. What it says of speed and lines is worked out from the tables;
//! what it says of what a crate can do is from that crate's documentation.

use std::fmt::Write as _;

use benches::machine::machine;

use crate::task::{Outcome, Task};

/// From how many times as fast on a task counts for one or the other; anything nearer is a tie.
const CLEAR: f64 = 1.2;

/// A task with what its ways took.
pub(crate) type Measured = (Task, Vec<Outcome>);

/// A task's table.
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

/// The fastest of our ways, and the fastest of the peers'.
fn fastest(outcomes: &[Outcome]) -> (&Outcome, Option<&Outcome>) {
    let least = |ours: bool| {
        let some = outcomes[1..]
            .iter()
            .filter(|way| (way.by == "ours") == ours);
        some.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    };
    (
        least(true).expect("every task is done by ours"),
        least(false),
    )
}

/// For each task the fastest way of either side.
fn summary(measured: &[Measured]) -> String {
    let mut table = String::from(
        "| task | ours, us | over the first row | fastest peer | its us | over ours | lines, ours and its |\n\
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

/// The tasks on which the fastest peer's time, over ours, is such a ratio.
fn where_over(measured: &[Measured], holds: impl Fn(f64) -> bool) -> String {
    let mut list = String::new();
    for (task, outcomes) in measured {
        let (ours, Some(peer)) = fastest(outcomes) else {
            continue;
        };
        let over = peer.seconds / ours.seconds;
        if holds(over) {
            let _ = writeln!(
                list,
                "- {}: {} ({}) takes {over:.2} times the time of ours ({}), in {} lines against {}.",
                task.title, peer.by, peer.how, ours.how, peer.lines, ours.lines
            );
        }
    }
    if list.is_empty() {
        list.push_str("- None of these tasks.\n");
    }
    list
}

/// The tasks on which the fastest peer's code is the shorter.
fn shorter(measured: &[Measured]) -> String {
    let pairs = measured
        .iter()
        .map(|(task, outcomes)| (task, fastest(outcomes)));
    let shorter = pairs.filter_map(|(task, (ours, peer))| {
        let peer = peer.filter(|peer| peer.lines < ours.lines)?;
        let (title, by) = (&task.title, peer.by);
        Some(format!(
            "- {title}: {by}, {} lines against {}.\n",
            peer.lines, ours.lines
        ))
    });
    shorter.collect()
}

/// The page of all tasks.
pub(crate) fn page(measured: &[Measured]) -> String {
    let tables: Vec<String> = measured.iter().map(table).collect();
    let ahead = where_over(measured, |over| over >= CLEAR);
    let level = where_over(measured, |over| over < CLEAR && over * CLEAR > 1.0);
    let behind = where_over(measured, |over| over * CLEAR <= 1.0);
    let shorter = shorter(measured);
    format!(
        include_str!("page.md"),
        machine = machine(),
        clear = CLEAR,
        summary = summary(measured),
        ahead = ahead,
        level = level,
        behind = behind,
        shorter = shorter,
        tables = tables.join("\n")
    )
}
