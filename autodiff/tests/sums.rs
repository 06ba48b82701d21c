//! Sums of a million numbers in `f32`. A running sum of equal numbers would be off by up to a percent.

use autodiff::{Dual, Real, Var, jvp, value_and_gradient};

const MANY: usize = 1_000_000;

/// Asserts that a number is right to 5e-6: some hundred roundings, as sums by parts and the sums over 128 points of each
/// lane have. A running sum of a million is off by 1e-3 and more.
#[track_caller]
fn assert_near(found: f32, expected: f64) {
    let error = f64::from(found) / expected - 1.0;
    assert!(error.abs() < 5e-6, "{found}, not {expected}");
}

#[test]
fn lengths_of_many_numbers_keep_their_digits() {
    let x = vec![0.1_f32; MANY];
    let each = f64::from(0.1_f32);
    let (value, slopes) = value_and_gradient(Var::norm, &x);
    for value in [
        value,
        f32::norm(&x),
        f32::norm(&x.iter().map(|x| x * 1e-25).collect::<Vec<_>>()) / 1e-25,
    ] {
        assert_near(value, 1e3 * each);
    }
    slopes.iter().for_each(|&slope| assert_near(slope, 1e-3));
    let (_, along) = jvp(|x| vec![Dual::norm(x)], &x, &vec![1.0; MANY]);
    assert_near(along[0], 1e3);
}

#[test]
fn sums_of_many_powers_keep_their_digits() {
    for each in [0.0, -3.0, 50.0] {
        let x = vec![each; MANY];
        let (value, slopes) = value_and_gradient(Var::logsumexp, &x);
        let expected = f64::from(each) + (MANY as f64).ln();
        assert_near(value, expected);
        assert_near(f32::logsumexp(&x), expected);
        // Also that of the first term, which counts as the largest.
        slopes.iter().for_each(|&slope| assert_near(slope, 1e-6));
    }
    // Up to 128 numbers are added from first to last.
    let few: Vec<f32> = (0..128_u8).map(|k| f32::from(k).sin()).collect();
    let running = few.iter().fold(0.0_f32, |sum, x| x.mul_add(*x, sum));
    let plain = few.iter().fold(0.0_f32, |sum, x| x * x + sum);
    assert!([running.sqrt(), plain.sqrt()].contains(&f32::norm(&few)));
    assert_eq!(f32::sum_of(&few), few.iter().sum());
}
