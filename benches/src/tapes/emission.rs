//! Writes `adjoints.rs`, and tests that it is up to date.

use std::path::Path;

use autodiff::emit::adjoint;

use super::kernels::{Flight, Spring};

const HEADER: &str = "\
//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib adjoints_are_fresh`.

use autodiff::{Adjoint, Real};

use super::kernels::{Flight, Spring};
";

fn emitted() -> String {
    let parts = [
        adjoint("Spring", &[], |_| Spring),
        adjoint("Flight", &[], |_| Flight),
    ];
    [HEADER, &parts.join("\n")].join("\n")
}

#[test]
fn adjoints_are_fresh() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/tapes/adjoints.rs");
    let emitted = emitted();
    if std::env::var_os("EMIT").is_some() {
        std::fs::write(&path, &emitted).expect("the source folder can be written");
    }
    let checked_in = std::fs::read_to_string(&path).expect("the adjoints are checked in");
    assert!(
        checked_in == emitted,
        "the kernels have changed: see the head of {path:?}"
    );
}
