//! Special functions: the error function, and the logarithm of the gamma function with its derivatives.
//!
//! Floats and lanes take the values of functions of f64, which the table of elementary functions names. All other number
//! types evaluate series and continued fractions with enough terms for 31 digits. Slopes are computed by the same formulas
//! in every number type, and higher derivatives follow from them.

use super::rounding::{pi, round};
use crate::real::gamma::{FAR, Gamma, asymptotic, ln_sqrt_2_pi};
use crate::real::{Mask, Real};

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

/// From this number on, [`inverse_scaled_erfc`] gives the logarithm of the complementary error function. Below, it is the
/// logarithm of [`erfc`], which has all its digits there.
const FAR_OUT: f64 = 3.0;

/// Returns `e^(-x^2) / (sqrt(pi) erfc(x))` for `x >= FAR_OUT`, by the continued fraction of [`erfc_far`]. It takes 80
/// terms for 31 digits.
#[inline(always)]
fn inverse_scaled_erfc<R: Real>(x: R) -> R {
    let mut rest = R::zero();
    for k in (1..80).rev() {
        rest = R::lit(f64::from(k) * 0.5) / (x + rest);
    }
    x + rest
}

pub(super) fn ln_erfc<R: Real>(x: R) -> R {
    // Below 1/2 the function is near 1 or between 1 and 2.
    let near = R::select(x.less(0.5), (-x.erf()).ln_1p(), x.erfc().ln());
    let above = R::select(x.less(FAR_OUT), R::lit(FAR_OUT), x);
    let far = -(x * x) - (pi::<R>().sqrt() * inverse_scaled_erfc(above)).ln();
    R::select(x.less(FAR_OUT), near, R::select(x.less_equal(x), far, x))
}

/// Returns the slope of the logarithm of `erfc(x)`. Lanes evaluate it too.
#[inline(always)]
pub(super) fn ln_erfc_slope<R: Real>(x: R) -> R {
    let near = x.less(FAR_OUT);
    let end = R::lit(FAR_OUT);
    let [below, above] = [R::select(near, x, end), R::select(near, end, x)];
    let quotient = erf_slope(below) / below.erfc();
    -R::select(near, quotient, R::lit(2.0) * inverse_scaled_erfc(above))
}

// The gamma function.

/// Returns the [asymptotic] series at `y`, times `1 / y^2`.
#[inline(always)]
fn tail<R: Real>(of: Gamma, y: R) -> R {
    let inverse = y.recip();
    let r = inverse * inverse;
    asymptotic(of, r) * r
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
        let stirling = (y - R::lit(0.5)) * y.ln() - y + ln_sqrt_2_pi::<R>();
        let infinite = !y.finite() & y.less_equal(y);
        R::select(
            infinite,
            y,
            stirling + y * tail(Gamma::Ln, y) - product.ln(),
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
        y.ln() - R::lit(0.5) / y - tail(Gamma::Digamma, y) - sum
    };
    reflected(x, direct, |x, value| value - pi::<R>() * x.cot_pi())
}

pub(super) fn trigamma<R: Real>(x: R) -> R {
    let direct = |x: R| {
        let (y, sum) = moved(Gamma::Trigamma, x);
        let inverse = y.recip();
        sum + inverse * (R::one() + R::lit(0.5) * inverse + tail(Gamma::Trigamma, y))
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
    let terms = R::one() + inverse + tail(Gamma::Tetragamma, y);
    let value = -(two * sum + inverse * inverse * terms);
    let (pi, cot) = (pi::<R>(), x.cot_pi());
    R::select(
        negative,
        value + two * pi * pi * cot * cot_pi_slope(cot),
        value,
    )
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
