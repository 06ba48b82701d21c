//! Integer powers with the same bits in every build. The compiler's own powers are sometimes products and sometimes
//! calls of the system's `pow`, with different bits.

use std::ops::Mul;

use super::exact::two_product;
use super::primitive::Primitive;
use super::scalar::with_fma;

/// Up to this magnitude of the exponent, plain products are accurate: each adds at most an error of about an ulp.
pub(crate) const FEW: u32 = 8;

/// Computes `x^exponent`. Each squaring doubles the relative error so far. For exponents above [`FEW`], every number is
/// therefore a pair of floats. Then the error stays below an ulp of the result up to the largest exponent. If the
/// result or a factor is subnormal, the error is as large as with plain products.
#[inline(always)]
pub(crate) fn powi(x: f64, exponent: i32) -> f64 {
    let times = exponent.unsigned_abs();
    if times > FEW {
        return long_power_with_fma(x, exponent);
    }
    let power = by_squaring(1.0, x, times);
    if exponent < 0 { power.recip() } else { power }
}

/// Computes `one * base^times` by repeated squaring. The last square is skipped, because it is not needed and may
/// overflow.
#[inline(always)]
pub fn by_squaring<T: Copy + Mul<Output = T>>(one: T, base: T, mut times: u32) -> T {
    let (mut power, mut square) = (one, base);
    while times > 0 {
        if times % 2 == 1 {
            power = power * square;
        }
        times /= 2;
        if times > 0 {
            square = square * square;
        }
    }
    power
}

/// A float and a correction, whose sum is a more accurate number.
#[derive(Clone, Copy)]
struct Pair(f64, f64);

impl Mul for Pair {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (high, low) = two_product(self.0, other.0);
        let cross = self.0 * other.1 + self.1 * other.0;
        let rest = low + cross;
        let sum = high + rest;
        Pair(sum, rest - (sum - high))
    }
}

with_fma! {
    fn long_power_with_fma(x: f64, exponent: i32) -> f64 {
        long_power(x, exponent)
    }
}

#[inline(always)]
pub(super) fn long_power(x: f64, exponent: i32) -> f64 {
    let mut base = Pair(x, 0.0);
    if exponent < 0 {
        // The reciprocal is taken first: where the power overflows, its reciprocal would be zero or inaccurate
        // (subnormal).
        let inverse = x.recip();
        let rest = Primitive::mul_add(-inverse, x, 1.0);
        base = Pair(inverse, rest * inverse);
    }
    let power = by_squaring(Pair(1.0, 0.0), base, exponent.unsigned_abs());
    if power.0 != 0.0 && power.1.is_finite() {
        return power.0;
    }
    // If the power is out of range, the remainder is NaN, or both numbers of the pair have lost their sign. Plain
    // products give the right limit: 0, infinity or NaN.
    by_squaring(1.0, base.0, exponent.unsigned_abs())
}
