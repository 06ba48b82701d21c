//! The digamma function of floats, which keeps its digits near its zeros.

use super::double_double::DoubleDouble;
use super::special::{FAR, digamma};
use crate::elementary::BERNOULLI;

/// The zero of the digamma function above 0, as a double and its rounding error.
const ZERO: [f64; 2] = [1.4616321449683622, 9.549995429965697e-17];

/// The digamma function divided by `x - ZERO`, on `[1, 2]`, as a polynomial in `x - 1.5`. The coefficients interpolate
/// values of mpmath. The relative error is 5e-17.
const BY_ZERO: [f64; 23] = [
    0.9510558760318328,
    -0.4236274212814606,
    0.24054248424078697,
    -0.14840492305388092,
    0.09498872445289039,
    -0.06192213327548831,
    0.040760833940846085,
    -0.026975796659787055,
    0.017907248317313294,
    -0.011908220105959716,
    0.007927021796868154,
    -0.005279937255532708,
    0.003518106563802472,
    -0.0023454947397380833,
    0.0015633696313653504,
    -0.0010364584817312839,
    0.0006909255761282986,
    -0.00048595039220036254,
    0.00032395945401345196,
    -0.00014480643368061614,
    9.653646261410062e-05,
    -0.0001782188548855923,
    0.00011881232908510335,
];

/// Computes the digamma function in f64. Near its zeros the general formula would be a difference of numbers near 3.
pub(super) fn digamma_of_float(x: f64) -> f64 {
    if (0.0..10.0).contains(&x) {
        return moderate(x);
    }
    let value = digamma(x);
    // The terms of the general formula are about as large as this logarithm. A zero is where they cancel.
    if x < 0.0 && value.abs() < 2.0 + (1.0 - x).ln() {
        return below_zero(x);
    }
    value
}

/// Computes the digamma function between 0 and 10.
fn moderate(mut x: f64) -> f64 {
    let mut moved = 0.0;
    while x > 2.0 {
        x -= 1.0;
        moved += 1.0 / x;
    }
    if x < 1.0 {
        moved = -1.0 / x.abs();
        x += 1.0;
    }
    let polynomial = BY_ZERO.iter().rev();
    let by_zero = polynomial.fold(0.0, |sum, coefficient| sum * (x - 1.5) + coefficient);
    ((x - ZERO[0]) - ZERO[1]) * by_zero + moved
}

fn wide(x: f64) -> DoubleDouble {
    DoubleDouble::from(x)
}

/// Computes the digamma function at a negative number in 31 digits, from its value at `1 - x`. Next to a zero, 16 of them
/// cancel.
fn below_zero(x: f64) -> f64 {
    let (mut y, mut sum) = (DoubleDouble::new(1.0, -x), wide(0.0));
    while y.to_f64() < FAR {
        sum += wide(1.0) / y;
        y += wide(1.0);
    }
    let inverse = wide(1.0) / y;
    let (square, mut series) = (inverse * inverse, wide(0.0));
    for (k, [numerator, denominator]) in BERNOULLI.into_iter().enumerate().rev() {
        let factor = wide(2.0 * (k + 1) as f64);
        series = (wide(numerator) / (wide(denominator) * factor) + series) * square;
    }
    (ln(y) - wide(0.5) * inverse - series - sum - pi_cot_pi(x)).to_f64()
}

const PI: [f64; 2] = [std::f64::consts::PI, 1.2246467991473532e-16];
const LN_2: [f64; 2] = [std::f64::consts::LN_2, 2.3190468138462996e-17];

/// Returns the logarithm of a number of at least 1, by the series of the inverse hyperbolic tangent.
fn ln(y: DoubleDouble) -> DoubleDouble {
    let exponent = y.to_f64().log2().round();
    let share = y.scaled(-(exponent as i32));
    let t = (share - wide(1.0)) / (share + wide(1.0));
    // The magnitude of `t` is at most 0.18, so the first omitted term is below 1e-33.
    let series = (0..22).rev().fold(wide(0.0), |sum, k| {
        wide(1.0) / wide(f64::from(2 * k + 1)) + t * t * sum
    });
    wide(exponent) * DoubleDouble::new(LN_2[0], LN_2[1]) + wide(2.0) * t * series
}

/// Returns `pi cot(pi x)`, as [`cot_pi`](super::special::cot_pi) computes it.
fn pi_cot_pi(x: f64) -> DoubleDouble {
    let (pi, rest) = (DoubleDouble::new(PI[0], PI[1]), x - x.round());
    let size = rest.abs();
    let near = size < 0.25;
    let angle = pi * wide(if near { size } else { 0.5 - size });
    // The angle is below 0.79, so the first omitted term is below 1e-34.
    let series = |first: u32| {
        (1..16).rev().fold(wide(1.0), |sum, k| {
            let k = f64::from(2 * k + first);
            wide(1.0) - angle * angle / wide(k * (k - 1.0)) * sum
        })
    };
    let (sin, cos) = (angle * series(1), series(0));
    let value = pi * if near { cos / sin } else { sin / cos };
    if rest < 0.0 { -value } else { value }
}
