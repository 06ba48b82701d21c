//! Exponential, hyperbolic tangent, sine and cosine. They only use additions, multiplications and one division, and are
//! written once for scalars and SIMD lanes.
//!
//! System math libraries (libm) differ from each other and have no SIMD lanes. These functions give the same bits on
//! every system, because every multiply-add is fused, in hardware or in software. Errors, measured against correctly
//! rounded values by `tests/rules.rs`: at most 2 ulp for `exp`, 4 for `tanh`, and 2 for `sin` and `cos` away from their
//! zeros.
//!
//! Range reduction and the splitting of constants follow J.-M. Muller, *Elementary Functions*, 3rd ed., chapter 11
//! (Cody and Waite's method).

use std::ops::{Add, Div, Mul, Sub};

/// A float or a register of floats, with the operations that elementary functions need.
pub(crate) trait Primitive:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The type of a single float. It has the constants for its precision.
    type Scalar: Primitive;
    /// The highest power in the series of the exponential; an odd number.
    const EXP_TERMS: usize = Self::Scalar::EXP_TERMS;
    /// The number of terms after the first term in the series of sine and cosine. The last power in the series of the
    /// sine is `2 SIN_TERMS + 1`.
    const SIN_TERMS: usize = Self::Scalar::SIN_TERMS;
    /// `ln 2` as a sum of floats, the largest first.
    const LN_2: [f64; 2] = Self::Scalar::LN_2;
    /// `pi / 2` as a sum of floats, the largest first.
    const PI_2: [f64; 3] = Self::Scalar::PI_2;
    /// A large constant. Adding it to a number and subtracting it again rounds the number to an integer, with ties to
    /// even.
    const ROUNDING: f64 = Self::Scalar::ROUNDING;
    /// Below the first number the exponential is 0, above the second it is infinite.
    const EXP_RANGE: [f64; 2] = Self::Scalar::EXP_RANGE;
    /// Up to this magnitude of the argument, the exponential is a normal number.
    const EXP_MODERATE: f64 = Self::Scalar::EXP_MODERATE;
    /// From this number on `tanh` rounds to 1.
    const TANH_ONE: f64 = Self::Scalar::TANH_ONE;

    fn constant(value: f64) -> Self;
    /// Computes `self * a + b` with one rounding. (MinGW's own function rounds twice.)
    fn mul_add(self, a: Self, b: Self) -> Self;
    /// Rounds to the nearest integer. The argument must be well below [`ROUNDING`](Self::ROUNDING).
    #[inline(always)]
    fn round(self) -> Self {
        let shift = Self::constant(Self::ROUNDING);
        (self + shift) - shift
    }
    /// Computes `2^self`. The argument must be an integer within the exponent range of normal numbers.
    fn exp2_integer(self) -> Self;
    /// Returns `if_less` where `self < bound`, and `otherwise` elsewhere.
    fn where_less(self, bound: Self, if_less: Self, otherwise: Self) -> Self;
    fn magnitude(self) -> Self;
    /// Returns `self`, which must not be negative, with the sign bit of `other`.
    fn with_sign_of(self, other: Self) -> Self;
}

/// `1/k!` for `k = 0 ... 17`.
const INVERSE_FACTORIAL: [f64; 18] = {
    let (mut inverses, mut factorial, mut k) = ([1.0; 18], 1.0, 1);
    while k < 18 {
        // The factorial is exact, because 17! is below 2^53. So only its inverse is rounded.
        factorial *= k as f64;
        inverses[k] = 1.0 / factorial;
        k += 1;
    }
    inverses
};

/// Computes `x - n sum(parts)`, subtracting part by part. This is a loop, because a closure that is not inlined would
/// be compiled without the instructions of the lanes.
#[inline(always)]
fn reduced<P: Primitive, const N: usize>(mut x: P, n: P, parts: [f64; N]) -> P {
    for k in 0..N {
        x = n.mul_add(P::constant(-parts[k]), x);
    }
    x
}

/// Returns `(e^r - 1, n)`, where `x = n ln 2 + r` and `|r| <= ln(2)/2`.
#[inline(always)]
fn reduced_exp_m1<P: Primitive>(x: P) -> (P, P) {
    let n = (x * P::constant(std::f64::consts::LOG2_E)).round();
    let r = reduced(x, n, P::LN_2);
    // Even and odd powers are summed separately: two short chains of operations instead of a long one.
    let square = r * r;
    let mut odd = P::constant(INVERSE_FACTORIAL[P::EXP_TERMS]);
    let mut even = P::constant(INVERSE_FACTORIAL[P::EXP_TERMS - 1]);
    for k in (1..P::EXP_TERMS / 2).rev() {
        odd = odd.mul_add(square, P::constant(INVERSE_FACTORIAL[2 * k + 1]));
        even = even.mul_add(square, P::constant(INVERSE_FACTORIAL[2 * k]));
    }
    // e^r - 1 = r + r^2 (1/2 + r/6 + ...)
    let tail = odd.mul_add(r, even);
    (square.mul_add(tail, r), n)
}

#[inline(always)]
pub(crate) fn exp<P: Primitive>(x: P) -> P {
    let [least, most] = P::EXP_RANGE;
    let (expm1, n) = reduced_exp_m1(x);
    // Multiplies by 2^n in two steps, because 2^n itself may be outside the normal range.
    let half = (n * P::constant(0.5)).round();
    let scaled = (P::constant(1.0) + expm1) * half.exp2_integer() * (n - half).exp2_integer();
    let low = x.where_less(P::constant(least), P::constant(0.0), scaled);
    P::constant(most).where_less(x, P::constant(f64::INFINITY), low)
}

/// Like [`exp`], for an argument so small in magnitude that the result and the power of two are normal numbers. It has
/// the same bits, because the products with powers of two are exact.
#[inline(always)]
pub(crate) fn moderate_exp<P: Primitive>(x: P) -> P {
    let (expm1, n) = reduced_exp_m1(x);
    (P::constant(1.0) + expm1) * n.exp2_integer()
}

/// Computes `tanh x = (e^2x - 1) / (e^2x + 1)`, without cancellation in the numerator.
#[inline(always)]
pub(crate) fn tanh<P: Primitive>(x: P) -> P {
    let (one, two) = (P::constant(1.0), P::constant(2.0));
    let limit = P::constant(P::TANH_ONE);
    let size = x.magnitude();
    let size = limit.where_less(size, limit, size);
    let (expm1, n) = reduced_exp_m1(two * size);
    let power = n.exp2_integer();
    // The product with a power of two is exact, so only the sum is rounded.
    let numerator = power * expm1 + (power - one);
    (numerator / (numerator + two)).with_sign_of(x)
}

/// The largest magnitude, in radians, for [`sin_cos`]. Beyond it the reduction by [`Primitive::PI_2`] loses digits, so
/// callers use the system's sine and cosine.
pub(crate) const SIN_RANGE: f64 = 1e4;

/// Computes `x - n pi/2`. The signs are chosen so that for `n = 0` every product is a negative zero. Adding a negative
/// zero to `x = -0` keeps the sign of `x`.
#[inline(always)]
fn reduced_angle<P: Primitive>(mut x: P, n: P) -> P {
    let minus_n = P::constant(0.0) - n;
    for k in 0..P::PI_2.len() {
        let part = P::PI_2[k];
        let of_its_sign = if part < 0.0 { minus_n } else { n };
        x = of_its_sign.mul_add(P::constant(-part.abs()), x);
    }
    x
}

/// Returns `(sin x, cos x)` for `|x| <= SIN_RANGE`.
#[inline(always)]
pub(crate) fn sin_cos<P: Primitive>(x: P) -> (P, P) {
    let n = (x * P::constant(std::f64::consts::FRAC_2_PI)).round();
    let r = reduced_angle(x, n);
    let square = r * r;
    let sign = if P::SIN_TERMS % 2 == 0 { 1.0 } else { -1.0 };
    let mut sin = P::constant(sign * INVERSE_FACTORIAL[2 * P::SIN_TERMS + 1]);
    let mut cos = P::constant(sign * INVERSE_FACTORIAL[2 * P::SIN_TERMS]);
    for k in (1..P::SIN_TERMS).rev() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        sin = sin.mul_add(square, P::constant(sign * INVERSE_FACTORIAL[2 * k + 1]));
        cos = cos.mul_add(square, P::constant(sign * INVERSE_FACTORIAL[2 * k]));
    }
    // Adding +0 keeps the factor of r from being -0. Otherwise its product with r = -0 would be +0, but sin(-0) is -0.
    let sin = sin.mul_add(square, P::constant(0.0)).mul_add(r, r);
    let cos = cos.mul_add(square, P::constant(1.0));
    quadrant(n, sin, cos)
}

/// Returns the sine and cosine of `n pi/2 + r`, given the sine and cosine of `r`.
#[inline(always)]
fn quadrant<P: Primitive>(n: P, sin: P, cos: P) -> (P, P) {
    let (zero, half) = (P::constant(0.0), P::constant(0.5));
    // n modulo 4, as one of -2, -1, 0, 1 and 2.
    let turn = n - P::constant(4.0) * (n * P::constant(0.25)).round();
    let odd = half.where_less(turn.magnitude(), P::constant(1.0), zero);
    let odd = P::constant(1.5).where_less(turn.magnitude(), zero, odd);
    let s = half.where_less(odd, cos, sin);
    let c = half.where_less(odd, sin, cos);
    // The sine is negative in quadrants 2 and -1, the cosine in quadrants 1 and 2 (2 and -2 are the same quadrant).
    let minus_s = turn.where_less(P::constant(-0.5), zero - s, s);
    let s = P::constant(1.5).where_less(turn, zero - s, minus_s);
    let minus_c = half.where_less(turn, zero - c, c);
    let c = turn.where_less(P::constant(-1.5), zero - c, minus_c);
    (s, c)
}

/// Implements [`Primitive`] for a float type. Arguments: the name of its multiply-add in `libm`, and the bias and the
/// bit position of its exponent.
macro_rules! operations {
    ($float:ident, $fma:ident, $bias:literal, $exponent:literal) => {
        #[inline(always)]
        fn constant(value: f64) -> Self {
            value as $float
        }
        #[inline(always)]
        fn mul_add(self, a: Self, b: Self) -> Self {
            #[cfg(all(windows, target_env = "gnu"))]
            return libm::$fma(self, a, b);
            #[cfg(not(all(windows, target_env = "gnu")))]
            self.mul_add(a, b)
        }
        #[inline(always)]
        fn exp2_integer(self) -> Self {
            // The last bits of the shifted number are the integer. They are moved to the exponent.
            let shifted = self + Self::constant(Self::ROUNDING);
            Self::from_bits(shifted.to_bits().wrapping_add($bias) << $exponent)
        }
        #[inline(always)]
        fn where_less(self, bound: Self, if_less: Self, otherwise: Self) -> Self {
            if self < bound { if_less } else { otherwise }
        }
        #[inline(always)]
        fn magnitude(self) -> Self {
            self.abs()
        }
        #[inline(always)]
        fn with_sign_of(self, other: Self) -> Self {
            self.copysign(other)
        }
    };
}

impl Primitive for f64 {
    type Scalar = Self;
    const EXP_TERMS: usize = 13;
    const SIN_TERMS: usize = 8;
    const LN_2: [f64; 2] = [std::f64::consts::LN_2, 2.3190468138462996e-17];
    const PI_2: [f64; 3] = [
        std::f64::consts::FRAC_PI_2,
        6.123233995736766e-17,
        -1.4973849048591698e-33,
    ];
    const ROUNDING: f64 = 6755399441055744.0; // 1.5 * 2^52
    const EXP_RANGE: [f64; 2] = [-745.2, 709.782712893384];
    const EXP_MODERATE: f64 = 708.0;
    const TANH_ONE: f64 = 20.0;

    operations!(f64, fma, 1023, 52);
}

impl Primitive for f32 {
    type Scalar = Self;
    const EXP_TERMS: usize = 7;
    const SIN_TERMS: usize = 5;
    // Each part is a single-precision float.
    const LN_2: [f64; 2] = [0.6931471824645996, -1.9046542121259336e-9];
    const PI_2: [f64; 3] = [
        1.5707963705062866,
        -4.371138828673793e-8,
        -1.7151245100058819e-15,
    ];
    const ROUNDING: f64 = 12582912.0; // 1.5 * 2^23
    const EXP_RANGE: [f64; 2] = [-104.0, 88.722839];
    const EXP_MODERATE: f64 = 87.0;
    const TANH_ONE: f64 = 10.0;

    operations!(f32, fmaf, 127, 23);
}
