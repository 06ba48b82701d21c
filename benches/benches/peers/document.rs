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

fn summary(measured: &[Measured]) -> String {
    let mut table = String::from(
        "| task | ours, us | fastest peer | its us | over ours | our lines | its lines |\n\
         | --- | --- | --- | --- | --- | --- | --- |\n",
    );
    for (task, outcomes) in measured {
        let (ours, peer) = fastest(outcomes);
        let us = ours.seconds * 1e6;
        let _ = match peer {
            Some(peer) => writeln!(
                table,
                "| {} | {us:.1} | {}, {} | {:.1} | {:.2} | {} | {} |",
                task.title,
                peer.by,
                peer.how,
                peer.seconds * 1e6,
                peer.seconds / ours.seconds,
                ours.lines,
                peer.lines
            ),
            None => writeln!(
                table,
                "| {} | {us:.1} | | | | {} | |",
                task.title, ours.lines
            ),
        };
    }
    table
}

/// A list of the tasks on which the fastest peer takes so many times our time, and how many.
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

pub(crate) fn page(measured: &[Measured]) -> String {
    let tables: Vec<String> = measured.iter().map(table).collect();
    let ahead = where_over(measured, |over| over >= CLEAR);
    let level = where_over(measured, |over| over < CLEAR && over * CLEAR > 1.0);
    let behind = where_over(measured, |over| over * CLEAR <= 1.0);
    format!(
        include_str!("page.md"),
        machine = machine(),
        clear = CLEAR,
        summary = summary(measured),
        ahead = ahead,
        level = level,
        behind = behind,
        tables = tables.join("\n")
    )
}
