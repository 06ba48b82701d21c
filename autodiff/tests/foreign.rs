//! Traits of other crates: each method of an element must agree with the same method of f64.

use std::fmt::Display;
use std::iter::Sum;

use autodiff::{Dual, Element, Tape, Var};
use nalgebra::RealField;
use num_traits::{Float, FromPrimitive, Num, NumAssign, Signed};

/// The largest relative difference from f64. Most functions of elements call those of f64. Some are composed of two or
/// three functions with a rounding error each, which an argument near 10 amplifies.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

#[track_caller]
fn assert_same(ours: Vec<Element<f64>>, plain: Vec<f64>) {
    assert_eq!(ours.len(), plain.len());
    for (k, (ours, plain)) in ours.into_iter().zip(plain).enumerate() {
        let same =
            ours.0 == plain || (ours.0 - plain).abs() <= ROUNDING * plain.abs().min(f64::MAX);
        assert!(same, "number {k}: {ours}, not {plain}");
    }
}

/// Pairs of numbers on both sides of zero. The larger one is the first or the second.
const POINTS: [(f64, f64); 4] = [(0.3, 2.5), (-1.75, 0.5), (2.25, -3.0), (-0.6, -0.2)];

fn of_float<T: Float>(x: T, y: T) -> Vec<T> {
    let (sin, cos) = x.sin_cos();
    let sign = |positive: bool| if positive { T::one() } else { T::zero() };
    vec![
        x.signum(),
        x.mul_add(y, x),
        x.powi(3),
        x.abs().powf(y),
        x.min(y),
        x.max(y),
        x.clamp(-T::one(), T::one()),
        (x - y).max(T::zero()),
        x.hypot(y),
        x.atan2(y),
        sin,
        cos,
        sign(x.is_sign_positive()),
        sign(x.is_sign_negative()),
        sign(T::nan().is_nan()),
        sign(T::neg_zero().is_sign_negative()),
        T::infinity().recip(),
        T::neg_infinity(),
    ]
}

#[test]
fn float_is_that_of_f64() {
    for (x, y) in POINTS {
        assert_same(of_float(Element(x), Element(y)), of_float(x, y));
        // This method is deprecated, but still belongs to the trait.
        #[allow(deprecated)]
        let differences = [Float::abs_sub(Element(x), Element(y)).0, x.abs_sub(y)];
        assert_eq!(differences[0], differences[1]);
    }
}

fn of_real_field<T: RealField + Copy>(x: T, y: T) -> Vec<T> {
    let (sin, cos) = x.sin_cos();
    let sign = |positive: bool| if positive { T::one() } else { T::zero() };
    vec![
        x.imaginary(),
        x.argument(),
        x.mul_add(y, x),
        sin,
        cos,
        x.abs().log(T::one() + T::one() + y.abs()),
        x.powi(-2),
        x.abs().powf(y),
        x.abs().powc(y),
        sign(x.is_finite()),
        sign(x.is_sign_positive()),
        x.max(y),
        x.min(y),
        RealField::clamp(x, -T::one(), T::one()),
        x.atan2(y),
        T::splat(x).extract(0),
        x.select(true, y),
        x.select(false, y),
    ]
}

fn constants<T: RealField + Copy>() -> Vec<T> {
    vec![
        T::two_pi(),
        T::frac_pi_2(),
        T::frac_pi_3(),
        T::frac_pi_4(),
        T::frac_pi_6(),
        T::frac_pi_8(),
        T::frac_1_pi(),
        T::frac_2_pi(),
        T::frac_2_sqrt_pi(),
        T::e(),
        T::log2_e(),
        T::log10_e(),
        T::ln_2(),
        T::ln_10(),
        T::min_value().expect("there is one"),
        T::max_value().expect("there is one"),
    ]
}

#[test]
fn real_field_is_that_of_f64() {
    for (x, y) in POINTS {
        assert_same(of_real_field(Element(x), Element(y)), of_real_field(x, y));
    }
    assert_same(constants(), constants::<f64>());
}

fn of_number<T: NumAssign + Signed + FromPrimitive + Copy + PartialOrd>(x: T, y: T) -> Vec<T> {
    let (mut difference, mut rest) = (x, x);
    difference -= y;
    rest %= y;
    let read = |text| T::from_str_radix(text, 10).unwrap_or_else(|_| T::zero());
    vec![
        difference,
        rest,
        Signed::abs(&x),
        Signed::abs_sub(&x, &y),
        Signed::signum(&x),
        read("-2.5"),
        T::from_i64(-7).expect("a number"),
        T::from_u64(7).expect("a number"),
        T::from_f64(0.1).expect("a number"),
    ]
}

#[test]
fn num_is_that_of_f64() {
    for (x, y) in POINTS {
        assert_same(of_number(Element(x), Element(y)), of_number(x, y));
    }
    let infinite = Element(f64::INFINITY);
    assert_eq!(Signed::abs_sub(&infinite, &infinite).0, 0.0);
    assert_eq!(Float::abs_sub(infinite, infinite).0, 0.0);
    assert!(<Element<f64> as Num>::from_str_radix("two", 10).is_err());
}

/// Asserts that a number prints, compares, adds up and is created like its value.
fn goes_by_its_value<T>(make: impl Fn(f64) -> T, value: impl Fn(T) -> f64)
where
    T: Copy + Display + PartialOrd + Sum + FromPrimitive,
{
    let [x, y] = [0.25, -3.5].map(&make);
    assert_eq!(format!("{x:.1}"), format!("{:.1}", 0.25));
    assert!(x > y && x == make(0.25) && x != y);
    assert_eq!(value([x, y, y].into_iter().sum()), -6.75);
    let made = [T::from_i64(-4), T::from_u64(4), T::from_f64(0.5)];
    assert_eq!(
        made.map(|made| made.map(&value)),
        [-4.0, 4.0, 0.5].map(Some)
    );
}

#[test]
fn numbers_go_by_their_values() {
    goes_by_its_value(|x| Dual::<f64, 1>::variable(x, 0), |x| x.value);
    Tape::default().record(&[1.0], |one| {
        goes_by_its_value(|x| one[0] * Var::constant(x), |x| x.value());
    });
}
