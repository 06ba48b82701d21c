//! Second derivatives at kinks, in all four nestings of modes: a test for each row of the second table in
//! `real.rs`.

use crate::common::forward_gradient;
use autodiff::{Function, Real, gradient, hessian};

enum Squared {
    Hypot,
    Abs,
    RootOfSquare,
    RootOfSum,
    Max,
    Min,
    Written,
}

impl Function for Squared {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        let y = match self {
            Self::Hypot => x[0].hypot(x[1]),
            Self::Abs => x[0].abs(),
            Self::RootOfSquare => (x[0] * x[0]).sqrt(),
            Self::RootOfSum => (x[0] * x[0] + x[1] * x[1]).sqrt(),
            Self::Max => x[0].max(R::zero()),
            Self::Min => x[0].min(R::zero()),
            Self::Written => return x[0] * x[0] + x[1] * x[1],
        };
        y * y
    }
}

/// The derivative by the first argument.
struct Slope<'a>(&'a Squared, bool);

impl Function for Slope<'_> {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        match self.1 {
            true => forward_gradient(self.0, x)[0],
            false => gradient(self.0, x)[0],
        }
    }
}

/// The second derivative at zero: forward over forward, forward over reverse, reverse over forward, reverse
/// over reverse.
fn seconds(function: Squared) -> [f64; 4] {
    let x = [0.0_f64; 2];
    let [of_forward, of_reverse] = [true, false].map(|forward| Slope(&function, forward));
    let found = [
        forward_gradient(&of_forward, &x)[0],
        forward_gradient(&of_reverse, &x)[0],
        gradient(&of_forward, &x)[0],
        gradient(&of_reverse, &x)[0],
    ];
    let hessian = hessian(&function, &x)[0][0];
    assert!(hessian == found[1] || hessian.is_nan() && found[1].is_nan());
    found
}

#[track_caller]
fn assert_seconds(function: Squared, expected: f64) {
    let found = seconds(function);
    let same = |x: &f64| *x == expected || x.is_nan() && expected.is_nan();
    assert!(found.iter().all(same), "{found:?}, not {expected}");
}

#[test]
fn the_derivative_of_a_chosen_zero_is_zero() {
    assert_seconds(Squared::Abs, 0.0);
    assert_seconds(Squared::Hypot, 0.0);
    assert_seconds(Squared::Max, 0.0);
    assert_seconds(Squared::Min, 0.0);
}

#[test]
fn an_infinite_slope_times_zero_has_no_second_derivative() {
    assert_seconds(Squared::RootOfSquare, f64::NAN);
    assert_seconds(Squared::RootOfSum, f64::NAN);
}

#[test]
fn the_smooth_function_itself_has_its_second_derivative() {
    assert_seconds(Squared::Written, 2.0);
}
