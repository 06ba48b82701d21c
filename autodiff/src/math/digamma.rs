//! The digamma function of floats, which keeps its digits near its zeros.

use super::double_double::DoubleDouble;
use super::special::digamma;

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
    // The terms of the general formula are about as large as this logarithm. Near a zero they cancel, which costs up to 16
    // digits. Double-doubles have 31.
    if x < 0.0 && value.abs() < 2.0 + (1.0 - x).ln() {
        return digamma(DoubleDouble::from(x)).to_f64();
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
