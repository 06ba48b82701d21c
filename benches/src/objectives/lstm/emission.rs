//! Writes `adjoints.rs`, and tests that it is up to date.

use autodiff::emit::{adjoint, assert_fresh};

use super::{Add, Cell, Change, Gate, Hidden, Prediction, Product};

const HEADER: &str = "\
//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib are_fresh`.

use autodiff::Real;

use super::{Add, Cell, Change, Gate, Hidden, Prediction, Product};
";

#[test]
fn adjoints_are_fresh() {
    let parts = [
        adjoint("Gate", &[], |_| Gate),
        adjoint("Change", &[], |_| Change),
        adjoint("Cell", &[], |_| Cell),
        adjoint("Hidden", &[], |_| Hidden),
        adjoint("Product", &[], |_| Product),
        adjoint("Prediction", &[], |_| Prediction),
        adjoint("Add", &[], |_| Add),
    ];
    assert_fresh("src/objectives/lstm/adjoints.rs", HEADER, &parts);
}
