//! Rounded elements and remainders of elements must be bit-identical to those of floats.

use autodiff::{DoubleDouble, Element, Real, gradient, hessian};
use num_traits::Float;

/// Remainders must be exact to the last bit, even if the two numbers differ by many orders of magnitude. In their
/// derivative the integer quotient is constant.
#[test]
fn remainders_are_exact() {
    let numbers = [
        0.0,
        5e-324,
        1e-310,
        0.1,
        1.0,
        6.0,
        7.5,
        1e17,
        1.7e308,
        f64::INFINITY,
        f64::NAN,
    ];
    for a in numbers {
        for b in numbers {
            for [a, b] in [[a, b], [-a, b], [a, -b], [-a, -b]] {
                let (got, expected) = ((Element(a) % Element(b)).0, a % b);
                assert_eq!(got.is_nan(), expected.is_nan(), "{a} % {b}: {got}");
                if !expected.is_nan() {
                    assert_eq!(got.to_bits(), expected.to_bits(), "{a} % {b}: {got}");
                }
                let [a, b] = [a, b].map(|x| x as f32);
                let (got, expected) = ((Element(a) % Element(b)).0, a % b);
                assert!(got == expected || got.is_nan() && expected.is_nan());
            }
        }
    }
    fn remainder<R: Real>(x: &[R]) -> R {
        (Element(x[0]) % Element(x[1])).0
    }
    // 1 divided by 0.1 is 9 plus a rest, because the float 0.1 is a little more than a tenth.
    assert_eq!(gradient(remainder, &[1.0, 0.1]), [1.0, -9.0]);
    assert_eq!(gradient(remainder, &[-7.5, 2.0]), [1.0, 3.0]);
    assert_eq!(gradient(remainder, &[7.5, -2.0]), [1.0, 3.0]);
    assert_eq!(gradient(remainder, &[3.0, f64::INFINITY]), [1.0, 0.0]);
    assert_eq!(hessian(remainder, &[7.5, 2.0]), [[0.0; 2]; 2]);
}

/// Rounded numbers must be exact to the last bit, from zeros of both signs to the largest floats.
#[test]
fn rounding_is_exact_at_every_size() {
    type Pair = (fn(Element<f64>) -> Element<f64>, fn(f64) -> f64);
    let pairs: [Pair; 5] = [
        (Float::floor, f64::floor),
        (Float::ceil, f64::ceil),
        (Float::round, f64::round),
        (Float::trunc, f64::trunc),
        (Float::fract, f64::fract),
    ];
    let sizes = [0.0, 5e-324, 0.3, 0.5, 1.5, 2.5, 1e15 + 0.5, 3e18, 7e300];
    let largest = [2.0_f64.powi(1023), f64::MAX, f64::INFINITY, f64::NAN];
    for x in sizes.into_iter().chain(largest) {
        for x in [x, -x] {
            for (i, (ours, system)) in pairs.into_iter().enumerate() {
                let (got, expected) = (ours(Element(x)).0, system(x));
                let same = got.to_bits() == expected.to_bits() || got.is_nan() && expected.is_nan();
                assert!(same, "{i} of {x:e}: {got:e}");
            }
        }
    }
    assert_eq!(Element(f32::MAX).floor().0, f32::MAX);
    assert_eq!((Element(f64::MAX) % Element(1.0)).0, 0.0);
    let largest = DoubleDouble::from(f64::MAX);
    assert_eq!(Element(largest).trunc().0, largest);
}

/// The functions of floats are translations, which are shorter than the crate `libm` and compile sooner.
#[test]
fn floats_have_the_bits_of_libm() {
    type OfFloats = fn(f64) -> f64;
    let pairs: [(&str, OfFloats, OfFloats); 3] = [
        ("erf", Real::erf, libm::erf),
        ("erfc", Real::erfc, libm::erfc),
        ("ln_gamma", Real::ln_gamma, libm::lgamma),
    ];
    let ends = [
        0.0,
        -0.0,
        5e-324,
        -1e-310,
        1e-22,
        f64::MIN_POSITIVE,
        1e300,
        f64::INFINITY,
        -f64::INFINITY,
    ];
    let whole = (-40..40_i16).flat_map(|k| [0.0, 0.5, 1e-9].map(|more| f64::from(k) + more));
    // Sizes of all powers of two with irregular mantissas, then the range where formulas change, closely.
    let powers = (-1074..1024).map(|k| 2f64.powi(k) * (1.0 + (0.618 * f64::from(k)).fract().abs()));
    let near = (-60_000..60_000).map(|k| f64::from(k) * 5.1e-4);
    let all = ends.into_iter().chain(whole).chain(near);
    for x in all.chain(powers.flat_map(|x| [x, -x])) {
        for (name, ours, theirs) in pairs {
            let (ours, theirs) = (ours(x), theirs(x));
            let same = ours.to_bits() == theirs.to_bits() || ours.is_nan() && theirs.is_nan();
            assert!(same, "{name}({x:e}) is {ours:e}, not {theirs:e}");
        }
    }
}
