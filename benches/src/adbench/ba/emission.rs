//! Writes `partials.rs`, and tests that it is up to date.

use std::path::Path;

use autodiff::emit::partials;

use super::{Reprojection, WeightError};

const HEADER: &str = "\
//! Partials of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib are_fresh`.

use autodiff::{Partials, Real};

use super::{Reprojection, WeightError};
";

#[test]
fn partials_are_fresh() {
    let parts = [
        partials("Reprojection", &[], |_| Reprojection),
        partials("WeightError", &[], |_| WeightError),
    ];
    let emitted = [HEADER, &parts.join("\n")].join("\n");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/adbench/ba/partials.rs");
    if std::env::var_os("EMIT").is_some() {
        std::fs::write(&path, &emitted).expect("the source folder can be written");
    }
    let checked_in = std::fs::read_to_string(&path).expect("the partials are checked in");
    assert!(
        checked_in == emitted,
        "the kernels have changed: see the head of {path:?}"
    );
}
