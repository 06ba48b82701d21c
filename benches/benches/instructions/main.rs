//! Counts the instructions of functions and of their gradients. Other load on the machine does not change the counts.
//! Needs valgrind; without it the bench prints that it is skipped.
//!
//! `cargo bench -p benches --bench instructions` prints a section of `RESULTS.md`.

mod callgrind;
mod document;
mod works;

use std::process::ExitCode;

use benches::machine::section;
use works::{CountTable, tables};

/// The argument with which the bench calls itself under valgrind. `--work NUMBER REPETITIONS` does one piece of work.
const WORK: &str = "--work";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let tables = tables();
    if let [flag, work, repeats] = &arguments[..]
        && flag == WORK
    {
        return work_of(&tables, work, repeats);
    }
    let Some(version) = callgrind::version() else {
        println!("SKIPPED: valgrind, which counts instructions, is not on the path");
        return ExitCode::SUCCESS;
    };
    match count(&tables) {
        Ok(counts) => {
            let page = document::page(&tables, &counts, &version);
            let command = "cargo bench -p benches --bench instructions";
            println!("{}", section("Instructions", command, &page));
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Does the piece of work with the given number.
fn work_of(tables: &[CountTable], work: &str, repeats: &str) -> ExitCode {
    let mut works = tables.iter().flat_map(CountTable::works);
    let found = work.parse().ok().and_then(|work| works.nth(work));
    match (found, repeats.parse()) {
        (Some(work), Ok(repeats)) => {
            (work.run)(repeats);
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!(
                "error: `{WORK} {work} {repeats}`: expected the number of a piece of work, then the \
                 number of repetitions"
            );
            ExitCode::FAILURE
        }
    }
}

/// Returns the number of instructions per unit for each work of all tables, in order.
fn count(tables: &[CountTable]) -> Result<Vec<f64>, String> {
    let all = tables.iter().flat_map(CountTable::works).count();
    let works = tables.iter().flat_map(CountTable::works).enumerate();
    works
        .map(|(number, work)| {
            eprintln!("counting piece of work {} of {all}", number + 1);
            let counted = callgrind::instructions(&[WORK, &number.to_string()], work.repeats)?;
            Ok(counted / work.units)
        })
        .collect()
}
