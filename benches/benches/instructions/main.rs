//! How many instructions gradients take, and what they are gradients of: counts that a busy
//! machine does not disturb, beside the times of the other benches. Needs valgrind, and says so
//! where there is none.
//!
//! `cargo bench -p benches --bench instructions` prints a section of `RESULTS.md`.

mod document;
mod works;

use std::process::ExitCode;

use benches::callgrind::{self, CountError};
use benches::machine::section;
use works::{CountTable, tables};

/// The argument that makes this program do the work of that number, so many times: how it calls
/// itself under valgrind.
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
        println!("skipped: instructions are counted by valgrind, and none is on the path");
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
            eprintln!("instructions: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Does one work, by its number among all.
fn work_of(tables: &[CountTable], work: &str, repeats: &str) -> ExitCode {
    let mut works = tables.iter().flat_map(CountTable::works);
    let found = work.parse().ok().and_then(|work| works.nth(work));
    match (found, repeats.parse()) {
        (Some(work), Ok(repeats)) => {
            (work.run)(repeats);
            ExitCode::SUCCESS
        }
        _ => {
            eprintln!("instructions: '{WORK} {work} {repeats}' is no work and its repetitions");
            ExitCode::FAILURE
        }
    }
}

/// Instructions a unit of every work of every table, in order.
fn count(tables: &[CountTable]) -> Result<Vec<f64>, CountError> {
    let all = tables.iter().flat_map(CountTable::works).count();
    let works = tables.iter().flat_map(CountTable::works).enumerate();
    works
        .map(|(number, work)| {
            eprintln!("counting work {} of {all}", number + 1);
            let counted = callgrind::instructions(&[WORK, &number.to_string()], work.repeats)?;
            Ok(counted / work.units)
        })
        .collect()
}
