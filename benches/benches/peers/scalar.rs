//! Measures elementary functions of single numbers.

use std::hint::black_box;

use autodiff::{Dual, Real};

use crate::task::{Task, Way, kept};

/// The number of arguments.
const COUNT: usize = 256;

pub(crate) fn tasks() -> [Task; 4] {
    [
        task("exp", f64::exp, Real::exp, Real::exp),
        task("sin", f64::sin, Real::sin, Real::sin),
        task("cos", f64::cos, Real::cos, Real::cos),
        task("tanh", f64::tanh, Real::tanh, Real::tanh),
    ]
}

fn task(
    name: &str,
    of_std: impl Fn(f64) -> f64 + 'static,
    ours: impl Fn(f64) -> f64 + 'static,
    of_duals: impl Fn(Dual<f64, 1>) -> Dual<f64, 1> + 'static,
) -> Task {
    let x = kept((0..COUNT).map(|i| 0.1 + 0.8 * (0.618 * i as f64).fract()));
    Task {
        title: format!("`{name}` of {COUNT} numbers"),
        about: "Elementary functions of the standard library, of floats, and of duals with one tangent.",
        source: include_str!("scalar.rs"),
        // The functions of both libraries are wrong by at most 4 units in the last place.
        tolerance: 1e-15,
        ways: vec![
            Way::new("std", "", &[], move || {
                black_box(x).iter().map(|&x| of_std(x)).collect()
            }),
            Way::new("ours", "floats", &[], move || {
                black_box(x).iter().map(|&x| ours(x)).collect()
            }),
            Way::new("ours", "duals", &[], move || {
                let value = |&x: &f64| black_box(of_duals(Dual::variable(x, 0))).value;
                black_box(x).iter().map(value).collect()
            }),
        ],
    }
}
