//! Tests of elementary functions that the table of `precision.rs` does not cover: bit-identical results in all modes,
//! single precision, and many arguments.

use autodiff::{Function, Real, gradient};

use crate::common::{Formula, Sym, assert_gradient, formula};

/// The name of a function, and the function: of one number or of two.
type One = (&'static str, fn(Sym) -> Sym);
type Two = (&'static str, fn(Sym, Sym) -> Sym);

/// Functions that change noticeably only over distances of at least 0.1, at every argument.
const BY_DISTANCE: [One; 5] = [
    ("exp", Sym::exp),
    ("sin", Sym::sin),
    ("cos", Sym::cos),
    ("tan", Sym::tan),
    ("tanh", Sym::tanh),
];
/// Functions that change noticeably only over distances of the size of the argument.
const BY_RATIO: [One; 7] = [
    ("sqrt", Sym::sqrt),
    ("rsqrt", Sym::rsqrt),
    ("recip", Sym::recip),
    ("ln", Sym::ln),
    ("abs", Sym::abs),
    ("cube", |x| x.powi(3)),
    ("inverse square", |x| x.powi(-2)),
];
const OF_TWO: [Two; 7] = [
    ("product", |x, y| x * y),
    ("quotient", |x, y| x / y),
    ("hypot", Sym::hypot),
    ("atan2", Sym::atan2),
    ("powf", Sym::powf),
    ("fma", |x, y| x.fma(y, x)),
    ("difference", |x, y| -(x - y)),
];

const ANGLES: [f64; 9] = [-30.0, -1.0, -1e-8, 0.0, 1e-300, 1e-3, 0.5, 3.0, 12.0];
const RATIOS: [f64; 9] = [1e-300, 1e-100, 1e-8, 0.3, 1.0, 7.5, 1e8, 1e90, 1e300];

/// Returns every function as a recording, with each of its arguments.
fn all<'a>(
    functions: &'a [One],
    at: &'a [f64],
) -> impl Iterator<Item = (&'static str, Formula, f64)> + 'a {
    functions.iter().flat_map(move |&(name, function)| {
        at.iter()
            .map(move |&x| (name, formula(1, |x| function(x[0])), x))
    })
}

#[test]
fn all_modes_agree_to_the_bit() {
    let far = [-1e300, -800.0, 800.0, 1e16];
    let ends = [f64::MIN_POSITIVE, 5e-324, f64::MAX];
    let near = all(&BY_DISTANCE, &ANGLES).chain(all(&BY_RATIO, &RATIOS));
    let further = all(&BY_DISTANCE, &far).chain(all(&BY_RATIO, &ends));
    for (_, function, x) in near.chain(further) {
        assert_gradient(&function, &[x], &gradient(|x| function.eval(x), &[x]));
    }
    for (_, function) in OF_TWO {
        let function = formula(2, |x| function(x[0], x[1]));
        for (a, b) in RATIOS.iter().flat_map(|&a| RATIOS.map(|b| (a, b))) {
            assert_gradient(&function, &[a, b], &gradient(|x| function.eval(x), &[a, b]));
        }
    }
}

#[test]
fn single_precision_follows_double() {
    for (name, function, x) in all(&BY_DISTANCE, &ANGLES).chain(all(&BY_RATIO, &RATIOS)) {
        let x = x as f32;
        let single = gradient(|x| function.eval(x), &[x])[0];
        let double = gradient(|x| function.eval(x), &[f64::from(x)])[0];
        if !single.is_normal() || !(double as f32).is_normal() {
            continue; // An intermediate over- or underflow.
        }
        // The tolerance is for a handful of operations, and for the cancellation in `1 - tanh^2`.
        let eps = f64::from(f32::EPSILON);
        let floor = f64::from(u8::from(name == "tanh")) * 2.0 * eps;
        let error = (f64::from(single) - double).abs();
        let allowed = 16.0 * eps * double.abs() + floor;
        assert!(error <= allowed, "{name} at {x}: {single}, f64 {double}");
    }
}

/// Returns the distance from a reference, in units of the last place of the reference.
fn ulps(a: f64, b: f64, epsilon: f64, least: f64) -> f64 {
    (a - b).abs() / (b.abs().max(least) * epsilon)
}

/// The arguments have all sizes and both signs, and are denser where the functions bend. The references are the
/// system's functions, which are accurate to 1 ulp. The reference for single precision is double precision.
#[test]
fn functions_of_the_crate_are_within_the_documented_ulps() {
    let double = |a: f64, b: f64| ulps(a, b, f64::EPSILON, f64::MIN_POSITIVE);
    let single = |a: f32, b: f64| match a == b as f32 {
        true => 0.0,
        false => ulps(a.into(), b, f32::EPSILON.into(), f32::MIN_POSITIVE.into()),
    };
    // Each row has a function, the system's function, the largest argument, the tolerance in ulps and an absolute
    // tolerance. The last is for sine and cosine near their zeros, where reducing the argument leaves an absolute
    // error.
    type Of<R> = (fn(R) -> R, fn(f64) -> f64, f64, f64, f64);
    let of_double: [Of<f64>; 4] = [
        (Real::exp, f64::exp, 700.0, 3.0, 0.0),
        (Real::tanh, f64::tanh, 22.0, 5.0, 0.0),
        (Real::sin, f64::sin, 2000.0, 3.0, 1e-19),
        (Real::cos, f64::cos, 2000.0, 3.0, 1e-19),
    ];
    let of_single: [Of<f32>; 4] = [
        (Real::exp, f64::exp, 80.0, 2.0, 0.0),
        (Real::tanh, f64::tanh, 80.0, 4.0, 0.0),
        (Real::sin, f64::sin, 80.0, 2.0, 1e-9),
        (Real::cos, f64::cos, 80.0, 2.0, 1e-9),
    ];
    for k in 0..40_000 {
        let t = f64::from(k) / 40_000.0;
        let small = 1e-12_f64.powf(t) * if k % 2 == 0 { 1.0 } else { -1.0 };
        let at = |largest: f64| [largest * (t * 2.0 - 1.0) + 0.37e-3, small];
        for (f, system, largest, allowed, floor) in of_double {
            for x in at(largest) {
                let (a, b) = (f(x), system(x));
                assert!(
                    a == b || double(a, b) <= allowed || (a - b).abs() < floor,
                    "{x}: {a}, {b}"
                );
            }
        }
        for (f, system, largest, allowed, floor) in of_single {
            for x in at(largest).map(|x| x as f32) {
                let (a, b) = (f(x), system(x.into()));
                let off = (f64::from(a) - b).abs();
                assert!(single(a, b) <= allowed || off < floor, "{x}: {a}, {b}");
            }
        }
    }
}

#[test]
fn extremes_give_limits_and_nan_is_passed_on() {
    let inf = f64::INFINITY;
    assert_eq!(
        [inf, -inf, 1e300, -1e300].map(Real::exp),
        [inf, 0.0, inf, 0.0]
    );
    assert_eq!(
        [inf, -inf, 1e300, 0.0].map(Real::tanh),
        [1.0, -1.0, 1.0, 0.0]
    );
    assert!(Real::exp(709.78_f64) < inf && Real::exp(709.79_f64) == inf);
    assert!(Real::exp(-745.0_f64) > 0.0 && Real::exp(-746.0_f64) == 0.0);
    for f in [Real::exp, Real::tanh, Real::sin, Real::cos] as [fn(f64) -> f64; 4] {
        assert!(f(f64::NAN).is_nan());
    }
    assert!(Real::sin(inf).is_nan());
    assert_eq!(Real::powi(2.0_f64, -1074), 5e-324);
    assert_eq!(Real::powi(-2.0_f64, 1025), -inf);
    assert_eq!(Real::powi(-0.0_f64, 1001).to_bits(), (-0.0_f64).to_bits());
    assert_eq!(Real::powi(-0.0_f64, -1001), -inf);
    assert_eq!(Real::powi(inf, -20), 0.0);
    assert_eq!(Real::powi(0.5_f64, i32::MIN), inf);
    assert!(Real::powi(f64::NAN, 20).is_nan());
    // By mpmath: 1.0000000001^(2^31 - 1).
    assert_eq!(Real::powi(1.0_f64 + 1e-10, i32::MAX), 1.239549965208056);
}
