//! Writes `adjoints.rs`, and tests that it is up to date.

use autodiff::emit::{adjoint_with_results, assert_fresh};

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
        adjoint_with_results("Gate", &[], |_| Gate),
        adjoint_with_results("Change", &[], |_| Change),
        adjoint_with_results("Cell", &[], |_| Cell),
        adjoint_with_results("Hidden", &[], |_| Hidden),
        adjoint_with_results("Product", &[], |_| Product),
        adjoint_with_results("Prediction", &[], |_| Prediction),
        adjoint_with_results("Add", &[], |_| Add),
    ];
    assert_fresh("src/objectives/lstm/adjoints.rs", HEADER, &parts);
}
