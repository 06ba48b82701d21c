//! Writes `adjoints.rs`, and tests that it is up to date.

use autodiff::emit::{adjoint, assert_fresh};

use super::kernels::{Flight, Spring};

const HEADER: &str = "\
//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib adjoints_are_fresh`.

use autodiff::Real;

use super::kernels::{Flight, Spring};
";

#[test]
fn adjoints_are_fresh() {
    let parts = [
        adjoint("Spring", &[], |_| Spring),
        adjoint("Flight", &[], |_| Flight),
    ];
    assert_fresh("src/tapes/adjoints.rs", HEADER, &parts);
}
