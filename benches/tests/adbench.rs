//! Every case of the folder against its reference answer, within the tolerance stated there.

use std::path::{Path, PathBuf};

use benches::adbench::{answer, cases, open};

/// The project's own cases, or those of `ADBENCH_DIR`.
fn folder() -> PathBuf {
    std::env::var_os("ADBENCH_DIR").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/adbench"),
        PathBuf::from,
    )
}

#[test]
fn every_answer_is_the_reference() {
    let cases = cases(&folder()).unwrap_or_else(|error| panic!("{error}"));
    for case in cases {
        let problem = open(case.kind, &case.file, None);
        let mut problem = problem.unwrap_or_else(|error| panic!("{error}"));
        problem.derivative();
        let with_derivative = problem.answer();
        problem.objective();
        // Both runs must find the value: the second overwrites what the first found.
        for found in [with_derivative, problem.answer()] {
            let comparison = answer::compare(&found, &case.reference);
            println!("{}: {comparison:?}", case.name);
            assert!(comparison.is_close(), "{}: {comparison:?}", case.name);
        }
    }
}
