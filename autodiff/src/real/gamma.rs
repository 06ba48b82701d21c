//! The asymptotic series of the gamma function's logarithm and of its derivatives.

use super::Real;

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

/// From this argument on, an [`asymptotic`] series has 31 digits.
pub(crate) const FAR: f64 = 16.0;

/// Which function an [`asymptotic`] series belongs to.
#[derive(Clone, Copy)]
pub(crate) enum Gamma {
    Ln,
    Digamma,
    Trigamma,
    Tetragamma,
}

/// Returns the asymptotic series at `y`, given `r = 1 / y^2`: the sum of `B_2k r^(k - 1)` for `k` from 1 on, each term with
/// the factor of the function.
#[inline(always)]
#[track_caller]
pub(crate) fn asymptotic<R: Real>(of: Gamma, r: R) -> R {
    let last = BERNOULLI.len() - 1;
    let mut sum: R = factor(of, last);
    for k in (0..last).rev() {
        sum = factor::<R>(of, k) + sum * r;
    }
    sum
}

/// Returns the factor of `r^k` in an [`asymptotic`] series.
#[inline(always)]
#[track_caller]
fn factor<R: Real>(of: Gamma, k: usize) -> R {
    let ([numerator, denominator], twice) = (BERNOULLI[k], 2.0 * (k + 1) as f64);
    let (numerator, denominator) = match of {
        Gamma::Ln => (numerator, denominator * twice * (twice - 1.0)),
        Gamma::Digamma => (numerator, denominator * twice),
        Gamma::Trigamma => (numerator, denominator),
        Gamma::Tetragamma => (numerator * (twice + 1.0), denominator),
    };
    R::lit(numerator) / R::lit(denominator)
}

/// Returns `ln(sqrt(2 pi))`.
#[inline(always)]
#[track_caller]
pub(crate) fn ln_sqrt_2_pi<R: Real>() -> R {
    R::lit(0.9189385332046728) + R::lit(-3.8782941580672414e-17)
}
