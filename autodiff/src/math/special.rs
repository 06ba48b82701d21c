//! Special functions: the error function, and the logarithm of the gamma function with its derivatives.
//!
//! Floats and lanes take the values of [`of_floats`]. Every other number type takes the series, which have terms for 31
//! digits. Slopes are computed by the same formulas in every number type, and higher derivatives follow from them.

use super::rounding::{pi, round};
use crate::elementary::Elementary;
use crate::real::{Mask, Real};

/// Returns the function for f64: that of the crate `libm`, or one of this file.
pub(super) fn of_floats(function: Elementary) -> Option<fn(f64) -> f64> {
    match function {
        Elementary::Erf => Some(libm::erf),
        Elementary::Erfc => Some(libm::erfc),
        Elementary::LnGamma => Some(libm::lgamma),
        Elementary::Digamma => Some(digamma_of_float),
        Elementary::Trigamma => Some(trigamma),
        Elementary::CotPi => Some(cot_pi),
        _ => None,
    }
}

// The error function.

/// Returns the slope of the error function, `2/sqrt(pi) e^(-x^2)`. Rounding `x^2` would cost up to three digits, so
/// the power is a product: `x` is split into a head with few digits, whose square is exact, and a small rest.
#[inline(always)]
pub(super) fn erf_slope<R: Real>(x: R) -> R {
    // From here on the slope is 0 in every number type.
    let end = R::lit(40.0);
    let x = R::select(end.less(x.abs()), end, x);
    let shifted = x.detach() * R::lit(134217729.0); // 2^27 + 1
    let head = shifted - (shifted - x.detach());
    let power = (-(head * head)).exp() * ((head - x) * (head + x)).exp();
    power * (R::lit(std::f64::consts::FRAC_2_SQRT_PI) + R::lit(1.533545961316588e-17))
}

/// Below this number the error function is computed by its power series, above by a continued fraction.
const NEAR: f64 = 1.5;

/// Computes the error function for `|x| <= NEAR` by a series of positive terms: `2/sqrt(pi) e^(-x^2) x (1 + r/3 (1 +
/// r/5 (…)))` with `r = 2 x^2`. The first omitted term is below 1e-33.
fn erf_near<R: Real>(x: R) -> R {
    let r = (x * x).scale(2.0);
    let mut sum = R::one();
    for k in (1..40).rev() {
        sum = R::one() + r / R::lit(f64::from(2 * k + 1)) * sum;
    }
    erf_slope(x) * x * sum
}

/// Computes `1 - erf(x)` for `x >= NEAR` by a continued fraction.
fn erfc_far<R: Real>(x: R) -> R {
    let mut rest = R::zero();
    for k in (1..340).rev() {
        rest = R::lit(f64::from(k) * 0.5) / (x + rest);
    }
    erf_slope(x) * R::lit(0.5) / (x + rest)
}

pub(super) fn erf<R: Real>(x: R) -> R {
    let size = x.abs();
    let far = R::one() - erfc_far(size);
    let far = R::select(x.less(0.0), -far, far);
    R::select(size.less(NEAR), erf_near(x), far)
}

pub(super) fn erfc<R: Real>(x: R) -> R {
    let far = erfc_far(x.abs());
    let far = R::select(x.less(0.0), R::lit(2.0) - far, far);
    R::select(x.abs().less(NEAR), R::one() - erf_near(x), far)
}

// The gamma function.

/// The Bernoulli numbers `B_2`, `B_4`, …, as quotients of integers that every number type represents exactly.
const BERNOULLI: [[f64; 2]; 17] = [
    [1.0, 6.0],
    [-1.0, 30.0],
    [1.0, 42.0],
    [-1.0, 30.0],
    [5.0, 66.0],
    [-691.0, 2730.0],
    [7.0, 6.0],
    [-3617.0, 510.0],
    [43867.0, 798.0],
    [-174611.0, 330.0],
    [854513.0, 138.0],
    [-236364091.0, 2730.0],
    [8553103.0, 6.0],
    [-23749461029.0, 870.0],
    [8615841276005.0, 14322.0],
    [-7709321041217.0, 510.0],
    [2577687858367.0, 6.0],
];

/// From this argument on, the sum of [`asymptotic`] has 31 digits.
const FAR: f64 = 16.0;

/// Which function an [`asymptotic`] sum belongs to.
#[derive(Clone, Copy)]
enum Gamma {
    Ln,
    Digamma,
    Trigamma,
    Tetragamma,
}

/// Returns the sum of the asymptotic series in even powers of `1/y`: of `B_2k / y^2k` with the factor of the function.
#[inline(always)]
fn asymptotic<R: Real>(of: Gamma, y: R) -> R {
    let inverse = y.recip();
    let (r, mut sum) = (inverse * inverse, R::zero());
    for k in (1..18).rev() {
        let [numerator, denominator] = BERNOULLI[k - 1];
        let k = 2.0 * k as f64;
        let (numerator, denominator) = match of {
            Gamma::Ln => (numerator, denominator * k * (k - 1.0)),
            Gamma::Digamma => (numerator, denominator * k),
            Gamma::Trigamma => (numerator, denominator),
            Gamma::Tetragamma => (numerator * (k + 1.0), denominator),
        };
        sum = (R::lit(numerator) / R::lit(denominator) + sum) * r;
    }
    sum
}

/// Adds 1 to `x >= 0` until it is at least [`FAR`]. Returns the result, and what the recurrence of the function adds up
/// to: the product of all `x + k` for [`Gamma::Ln`], otherwise the sum of their negative powers.
#[inline(always)]
fn moved<R: Real>(of: Gamma, x: R) -> (R, R) {
    let (mut y, one) = (x, R::one());
    let mut total = if matches!(of, Gamma::Ln) {
        one
    } else {
        R::zero()
    };
    for _ in 0..FAR as usize {
        let (near, inverse) = (y.less(FAR), y.recip());
        let next = match of {
            Gamma::Ln => total * y,
            Gamma::Digamma => total + inverse,
            Gamma::Trigamma => total + inverse * inverse,
            Gamma::Tetragamma => total + inverse * inverse * inverse,
        };
        total = R::select(near, next, total);
        y = R::select(near, y + one, y);
    }
    (y, total)
}

/// Evaluates a function at `x` by two formulas: `direct` for arguments that are not negative, and `reflected` of `x`
/// and `direct(1 - x)`.
#[inline(always)]
fn reflected<R: Real>(x: R, direct: impl Fn(R) -> R, reflected: impl Fn(R, R) -> R) -> R {
    let negative = x.less(0.0);
    // Adding 0 makes -0 the end of the positive numbers.
    let value = direct(R::select(negative, R::one() - x, x + R::zero()));
    if R::Mask::IS_SINGLE && !negative.any() {
        return value;
    }
    R::select(negative, reflected(x, value), value)
}

pub(super) fn ln_gamma<R: Real>(x: R) -> R {
    let direct = |x: R| {
        let (y, product) = moved(Gamma::Ln, x);
        let ln_sqrt_2_pi = R::lit(0.9189385332046728) + R::lit(-3.8782941580672414e-17);
        let stirling = (y - R::lit(0.5)) * y.ln() - y + ln_sqrt_2_pi;
        let infinite = !y.finite() & y.less_equal(y);
        R::select(
            infinite,
            y,
            stirling + y * asymptotic(Gamma::Ln, y) - product.ln(),
        )
    };
    // ln |gamma(x)| = ln pi - ln |sin(pi x)| - ln gamma(1 - x), and 1 / |sin| is the length of (1, cot).
    let reflection = |x: R, value: R| {
        let cot = x.cot_pi();
        let pole = !cot.less_equal(cot) & x.less_equal(x);
        R::select(
            pole,
            R::lit(f64::INFINITY),
            pi::<R>().ln() + cot.hypot(1.0).ln() - value,
        )
    };
    reflected(x, direct, reflection)
}

pub(super) fn digamma<R: Real>(x: R) -> R {
    let direct = |x: R| {
        let (y, sum) = moved(Gamma::Digamma, x);
        y.ln() - R::lit(0.5) / y - asymptotic(Gamma::Digamma, y) - sum
    };
    reflected(x, direct, |x, value| value - pi::<R>() * x.cot_pi())
}

pub(super) fn trigamma<R: Real>(x: R) -> R {
    let direct = |x: R| {
        let (y, sum) = moved(Gamma::Trigamma, x);
        let inverse = y.recip();
        sum + inverse * (R::one() + R::lit(0.5) * inverse + asymptotic(Gamma::Trigamma, y))
    };
    reflected(x, direct, |x, value| {
        -(pi::<R>() * cot_pi_slope(x.cot_pi())) - value
    })
}

/// Returns the slope of the trigamma function. Lanes evaluate it too.
#[inline(always)]
pub(super) fn tetragamma<R: Real>(x: R) -> R {
    let (negative, two) = (x.less(0.0), R::lit(2.0));
    let (y, sum) = moved(
        Gamma::Tetragamma,
        R::select(negative, R::one() - x, x + R::zero()),
    );
    let inverse = y.recip();
    let terms = R::one() + inverse + asymptotic(Gamma::Tetragamma, y);
    let value = -(two * sum + inverse * inverse * terms);
    let (pi, cot) = (pi::<R>(), x.cot_pi());
    R::select(
        negative,
        value + two * pi * pi * cot * cot_pi_slope(cot),
        value,
    )
}

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

/// Computes the digamma function in f64. Near its zero the general formula would be a difference of numbers near 3.
fn digamma_of_float(mut x: f64) -> f64 {
    if !(0.0..10.0).contains(&x) {
        return digamma(x);
    }
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

// The cotangent of multiples of pi, which continues the gamma function to negative arguments.

/// Computes `cot(pi x)` from the distance to the nearest integer, which is exact. At an integer the result is NaN,
/// because the limits from the two sides differ.
pub(super) fn cot_pi<R: Real>(x: R) -> R {
    let rest = x - round(x);
    let size = rest.abs();
    // Near a half integer, the cotangent is the tangent of the distance to it.
    let near = size.less(0.25);
    let angle = pi::<R>() * R::select(near, size, R::lit(0.5) - size);
    let (sin, cos) = (angle.sin(), angle.cos());
    let value = R::select(near, cos / sin, sin / cos);
    let value = R::select(rest.less(0.0), -value, value);
    R::select(size.less_equal(0.0), R::lit(f64::NAN), value)
}

/// Returns the slope of `cot(pi x)`, given its value.
#[inline(always)]
pub(super) fn cot_pi_slope<R: Real>(value: R) -> R {
    -pi::<R>() * (R::one() + value * value)
}
