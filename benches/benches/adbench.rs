//! Prints the table of ADBench's problems, with short samples. `adbench table` takes its time.

use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

use benches::adbench::measure::Effort;
use benches::adbench::{cases, table};

fn main() -> ExitCode {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/adbench");
    let effort = Effort {
        least: Duration::from_millis(20),
        limit: Duration::from_secs(1),
    };
    let cases = cases(&folder).map_err(table::TableError::from);
    match cases.and_then(|cases| table::page(&cases, effort)) {
        Ok(page) => {
            println!("{page}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
