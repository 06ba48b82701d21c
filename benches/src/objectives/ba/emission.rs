//! Writes `adjoints.rs`, and tests that it is up to date.

use autodiff::arrays::vjp_by_duals;
use autodiff::emit::{adjoint, assert_fresh};
use autodiff::{Kernel, Pullback};

use super::{INPUTS, Reprojection};

const HEADER: &str = "\
//! Adjoints of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib are_fresh`.

use autodiff::Real;

use super::Reprojection;
";

#[test]
fn adjoints_are_fresh() {
    let parts = [adjoint("Reprojection", &[], |_| Reprojection)];
    assert_fresh("src/objectives/ba/adjoints.rs", HEADER, &parts);
}

#[test]
fn emitted_cotangents_are_those_of_duals_also_without_rotation() {
    let numbers = |i: usize| std::array::from_fn(|k| ((7 * i + 3 * k) as f64 * 0.618).fract());
    for i in 0..9 {
        let mut x: [f64; INPUTS] = numbers(i);
        if i % 3 == 0 {
            x[..3].fill(0.0);
        }
        x[13] += 3.0; // in front of the camera
        let at = Pullback::new(&Reprojection, x, [[1.0, 0.0], [0.0, 1.0]]);
        let (rows, expected) = (Reprojection.vjp(at), vjp_by_duals(&Reprojection, at));
        for (got, expected) in rows.as_flattened().iter().zip(expected.as_flattened()) {
            // Some tens of roundings of terms of order one.
            assert!(
                (got - expected).abs() <= 1e-13,
                "{x:?}: {got} and {expected}"
            );
        }
    }
}
