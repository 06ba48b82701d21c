//! Special functions and functions of slices: the rows of the table in `kinks.md`, lanes, and the ends of the range.
//! Their values and derivatives inside the range are in the table of `precision.rs`.

use autodiff::{DoubleDouble, Function, Real, Tape, Var, gradient, hessian, value_and_gradient};

use crate::common::{Sym, assert_close, assert_gradients, formula, gradients};
use crate::in_lanes::values_and_gradients;

const INF: f64 = f64::INFINITY;
const NAN: f64 = f64::NAN;

#[test]
fn the_gamma_function_has_poles() {
    assert_gradients(
        |x| x[0].ln_gamma(),
        &[([0.0], [-INF]), ([-0.0], [-INF]), ([-2.0], [NAN])],
    );
    assert_gradients(|x| x[0].digamma(), &[([0.0], [INF]), ([-1.0], [NAN])]);
    assert_gradients(|x| x[0].trigamma(), &[([0.0], [-INF]), ([-1.0], [NAN])]);
    assert_gradients(
        |x| x[0].cot_pi(),
        &[([0.0], [NAN]), ([3.0], [NAN]), ([-1e300], [NAN])],
    );
    for pole in [0.0, -0.0, -1.0, -7.0] {
        assert_eq!(Real::ln_gamma(pole), INF);
    }
    assert_eq!([0.0_f64, -0.0].map(Real::digamma), [-INF; 2]);
    assert_eq!([0.0_f64, -0.0].map(Real::trigamma), [INF; 2]);
    assert!(
        [
            Real::digamma(-1.0_f64),
            Real::trigamma(-1.0),
            Real::cot_pi(-1.0)
        ]
        .iter()
        .all(|x| x.is_nan())
    );
    assert_eq!(
        [Real::ln_gamma(INF), Real::digamma(INF), Real::trigamma(INF)],
        [INF, INF, 0.0]
    );
}

#[test]
fn the_error_function_is_flat_far_out() {
    let far = [
        ([INF], [0.0]),
        ([-INF], [0.0]),
        ([30.0], [0.0]),
        ([NAN], [NAN]),
    ];
    assert_gradients(|x| x[0].erf(), &far);
    assert_gradients(|x| x[0].erfc(), &far);
    assert_eq!(
        [
            Real::erf(INF),
            Real::erf(-INF),
            Real::erfc(INF),
            Real::erfc(-INF)
        ],
        [1.0, -1.0, 0.0, 2.0]
    );
}

#[test]
fn entropies_end_at_zero() {
    assert_gradients(
        |x| x[0].xlogx(),
        &[([0.0], [-INF]), ([-0.0], [-INF]), ([-1.0], [NAN])],
    );
    assert_eq!([0.0_f64, -0.0].map(Real::xlogx), [0.0; 2]);
    assert_gradients(
        |x| x[0].xlogy(x[1]),
        &[
            ([0.0, 1.0], [0.0, 0.0]),
            ([0.0, 0.0], [-INF, 0.0]),
            ([-0.0, 0.0], [-INF, 0.0]),
            ([0.0, INF], [INF, 0.0]),
            ([0.0, -1.0], [NAN, 0.0]),
            ([2.0, 0.0], [-INF, INF]),
            ([2.0, -1.0], [NAN, NAN]),
        ],
    );
    // A probability of 0 that is a constant: the term passes nothing.
    assert_gradients(|x| Sym::lit(0.0).xlogy(x[0]), &[([0.0], [0.0])]);
    for y in [0.0, -1.0, INF] {
        assert_eq!(0.0_f64.xlogy(y), 0.0);
    }
    assert!(0.0_f64.xlogy(NAN).is_nan());
    // Where `x` is 0 but `y` is an ordinary number, nothing is special: the second derivatives are 1/y and 0.
    let second = hessian(|x| x[0].xlogy(x[1]), &[0.0, 4.0]);
    assert_eq!(second, [[0.0, 0.25], [0.25, 0.0]]);
}

#[test]
fn a_length_is_flat_at_the_origin() {
    assert_gradients(
        Sym::norm,
        &[
            ([0.0, 0.0, -0.0], [0.0; 3]),
            ([INF, 1.0, 0.0], [NAN, 0.0, 0.0]),
            ([0.0, -2.0, 0.0], [0.0, -1.0, 0.0]),
            ([0.0, 0.0, 2f64.powi(-700)], [0.0, 0.0, 1.0]),
            ([-(2f64.powi(700)), 0.0, 0.0], [-1.0, 0.0, 0.0]),
            // The inverse of a subnormal length is infinite.
            ([5e-324, 0.0, 0.0], [1.0, 0.0, 0.0]),
            ([0.0, -f64::from_bits(1 << 24), 0.0], [0.0, -1.0, 0.0]),
        ],
    );
    for (_, slopes) in gradients(&formula(2, Sym::norm), &[3, 4].map(f64::from_bits)) {
        assert_close(&slopes, &[0.6, 0.8], 1e-15);
    }
    let single = gradient(Var::norm, &[3, 4].map(f32::from_bits));
    assert_close(&single, &[0.6, 0.8], 1e-6);
    let origin = hessian(Var::norm, &[0.0; 2]);
    assert_eq!(origin, [[0.0; 2]; 2]);
    assert_eq!([f64::norm(&[]), f64::norm(&[1.0, INF])], [0.0, INF]);
    for unit in [2f64.powi(-1070), 2f64.powi(-600), 1.0, 2f64.powi(1000)] {
        assert_eq!(f64::norm(&[3.0 * unit, -4.0 * unit]), 5.0 * unit);
    }
    assert_eq!(f32::norm(&[3e30, 4e30]), 5e30);
    assert!(f64::norm(&[NAN, 1.0]).is_nan());
    let mut tape = Tape::new();
    tape.record(&[3.0, 4.0], Var::norm);
    assert_eq!(tape.len(), 4, "two inputs, the dot product and the root");
}

#[test]
fn the_largest_term_of_a_sum_of_powers_may_be_infinite() {
    assert_gradients(
        Sym::logsumexp,
        &[
            ([1000.0, 1000.0, -INF], [0.5, 0.5, 0.0]),
            ([-INF, -INF, 7.0], [0.0, 0.0, 1.0]),
            ([0.0, INF, INF], [0.0, 1.0, 0.0]),
            ([-INF, -INF, -INF], [1.0, 0.0, 0.0]),
            ([0.0, NAN, 1.0], [NAN; 3]),
        ],
    );
    assert_eq!(
        [
            f64::logsumexp(&[]),
            f64::logsumexp(&[-INF]),
            f64::logsumexp(&[0.0, INF])
        ],
        [-INF, -INF, INF]
    );
    assert!(f64::logsumexp(&[INF, NAN]).is_nan());
    assert_eq!(f64::logsumexp(&[-1000.0, -1000.0]), 2f64.ln() - 1000.0);
}

/// Where `sigmoid` and `erfc` are 0, the logarithms have their values.
#[test]
fn logarithms_of_functions_that_underflow_are_finite() {
    assert_gradients(
        |x| x[0].log_sigmoid(),
        &[
            ([-800.0], [1.0]),
            ([-1e300], [1.0]),
            ([800.0], [0.0]),
            ([-INF], [1.0]),
            ([INF], [0.0]),
        ],
    );
    assert_eq!(
        [-800.0_f64, -INF, INF].map(Real::log_sigmoid),
        [-800.0, -INF, 0.0]
    );
    assert_gradients(
        |x| x[0].ln_erfc(),
        &[([INF], [-INF]), ([-INF], [0.0]), ([NAN], [NAN])],
    );
    assert_eq!([INF, -INF].map(Real::ln_erfc), [-INF, 2f64.ln()]);
    assert!(Real::ln_erfc(NAN).is_nan());
    // By mpmath: log(erfc(30)) at 40 digits.
    assert_close(&[Real::ln_erfc(30.0_f64)], &[-903.9741171106439], 1e-15);
}

#[test]
fn the_beta_function_ends_at_zero() {
    assert_gradients(
        |x| x[0].ln_beta(x[1]),
        &[
            ([-1.0, 20.0], [NAN; 2]),
            ([3.0, -2.0], [NAN; 2]),
            ([NAN, 1.0], [NAN; 2]),
        ],
    );
    assert_eq!(
        [1.0, 30.0, INF].map(|y| 0.0_f64.ln_beta(y).is_sign_positive()),
        [true, true, false]
    );
    assert_eq!(
        [
            0.0_f64.ln_beta(1.0),
            0.0_f64.ln_beta(30.0),
            2.0_f64.ln_beta(INF)
        ],
        [INF, INF, -INF]
    );
    assert_eq!(1.0_f64.ln_beta(1.0), 0.0);
    // In 31 digits, the plain formula keeps enough digits in spite of its cancellation.
    let plain =
        |x: &[Var<DoubleDouble>]| x[0].ln_gamma() + x[1].ln_gamma() - (x[0] + x[1]).ln_gamma();
    let sizes = [0.3, 1.0, 7.0, 15.9, 16.1, 40.0, 1e4, 1e7];
    for (a, b) in sizes.iter().flat_map(|&a| sizes.map(|b| (a, b))) {
        let (value, slopes) = value_and_gradient(|x| x[0].ln_beta(x[1]), &[a, b]);
        let (exact, exact_slopes) = value_and_gradient(plain, &[a.into(), b.into()]);
        // From 16 on, each number keeps its digits; below, terms of up to 80 cancel.
        let least = if a.max(b) < 16.0 { 1.0 } else { 1e-15 };
        let numbers = [
            (value, exact),
            (slopes[0], exact_slopes[0]),
            (slopes[1], exact_slopes[1]),
        ];
        for (found, exact) in numbers {
            let exact = exact.to_f64();
            let error = (found - exact).abs() / exact.abs().max(least);
            assert!(error < 5e-14, "{a} {b}: {found}, not {exact}");
        }
    }
}

/// Every special function of one number, and the functions of slices.
fn all(x: &[Sym]) -> Sym {
    let (a, b) = (x[0], x[1]);
    let of_a =
        a.erf() + a.erfc() * a.ln_gamma() + a.digamma() * a.trigamma() + a.cot_pi() + a.xlogx();
    let of_a = of_a + a.ln_erfc() * a.log_sigmoid() + (a * a).ln_beta(b);
    of_a + a.xlogy(b) * Real::norm(&[a, b, a]) + Real::logsumexp(&[a, b, a * b])
}

/// The points are on both sides of the switches between formulas.
#[test]
fn lanes_agree_with_single_points() {
    let point = |k: u8| {
        vec![
            0.3 + 0.3701 * f64::from(k),
            (9.13 - 0.35 * f64::from(k)).abs(),
        ]
    };
    let points: Vec<Vec<f64>> = (0..50).map(point).collect();
    let all = formula(2, all);
    for (x, (value, slopes)) in points.iter().zip(values_and_gradients(&all, &points)) {
        // Lanes round multiply-adds once. Some twenty terms are summed.
        assert_close(&[value], &[all.eval(x)], 1e-13);
        assert_close(&slopes, &gradient(|x| all.eval(x), x), 1e-13);
    }
}

/// At the zero of the digamma function, where the logarithm of the gamma function is least, the slope keeps its digits.
#[test]
fn the_minimum_of_the_gamma_function_is_sharp() {
    // By mpmath: psi(0, 1.461632144968) at 40 digits.
    let slope = gradient(|x| x[0].ln_gamma(), &[1.461632144968])[0];
    let expected = -3.505395133995687e-13;
    assert!(((slope - expected) / expected).abs() < 1e-15, "{slope:e}");
}
