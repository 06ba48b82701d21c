//! Writes `partials.rs`, and tests that it is up to date.

use autodiff::emit::{assert_fresh, partials};
use autodiff::{Kernel, Real};

use super::{INPUTS, Reprojection};

const HEADER: &str = "\
//! Partials of the kernels, emitted from recordings of them: not to be edited. After a change of
//! a kernel: `EMIT=1 cargo test -p benches --lib are_fresh`.

use autodiff::Real;

use super::Reprojection;
";

#[test]
fn partials_are_fresh() {
    let parts = [partials("Reprojection", &[], |_| Reprojection)];
    assert_fresh("src/objectives/ba/partials.rs", HEADER, &parts);
}

/// The same kernel, differentiated by dual numbers.
struct Plain;

impl Kernel<INPUTS, 2> for Plain {
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; INPUTS]) -> [R; 2] {
        Reprojection.eval(x)
    }
}

#[test]
fn emitted_partials_are_those_of_duals_also_without_rotation() {
    let numbers = |i: usize| std::array::from_fn(|k| ((7 * i + 3 * k) as f64 * 0.618).fract());
    for i in 0..9 {
        let mut x: [f64; INPUTS] = numbers(i);
        if i % 3 == 0 {
            x[..3].fill(0.0);
        }
        x[13] += 3.0; // in front of the camera
        let ((y, rows), (expected, expected_rows)) = (Reprojection.partials(x), Plain.partials(x));
        for o in 0..2 {
            // Some tens of roundings of terms of order one.
            assert!((y[o] - expected[o]).abs() <= 1e-14);
            for (got, expected) in rows[o].iter().zip(expected_rows[o]) {
                assert!(
                    (got - expected).abs() <= 1e-13,
                    "{x:?}: {got} and {expected}"
                );
            }
        }
    }
}
