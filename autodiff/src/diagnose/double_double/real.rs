//! Implements [`Real`] for double-doubles.
//!
//! Arguments are reduced by constants of three or four floats, with exact products. Taylor series are summed from the
//! innermost term outward: `1 + r/2 (1 + r/3 (...))`. This needs no table of coefficients, and only the last two
//! operations contribute rounding errors. Roots and angles start from the value that the system computes in f64, and
//! one correction doubles the number of correct digits. The methods are those of Hida, Li and Bailey, *Library for
//! double-double and quad-double arithmetic* (2007).

use num_traits::{One, Zero};

use crate::elementary::Elementary;
use crate::math::exact::two_product;
use crate::math::{DoubleDouble, by_squaring};
use crate::real::{Accepts, Real};

/// `ln 2` as a sum of floats.
const LN_2: [f64; 3] = [
    std::f64::consts::LN_2,
    2.3190468138462996e-17,
    5.707708438416212e-34,
];
/// `pi / 2` as a sum of floats.
const PI_2: [f64; 4] = [
    std::f64::consts::FRAC_PI_2,
    6.123233995736766e-17,
    -1.4973849048591698e-33,
    5.562271104316826e-50,
];

/// The number of powers in the series of the exponential. For `|r| <= ln(2)/2` the last power contributes at most
/// `0.347^26 / 26! = 3e-39`.
const EXP_TERMS: u32 = 26;
/// The number of pairs of powers in the series of sine and cosine. For `|r| <= pi/4`, powers from the 28th on
/// contribute at most `0.786^28 / 28! = 4e-33`.
const SIN_TERMS: u32 = 15;
/// The number of terms in the series of the logarithm. For `s <= 0.172` the next term is `s^44 / 45 = 5e-36`.
const LN_TERMS: u32 = 22;

/// Returns `x - n * constant`.
fn reduced(x: DoubleDouble, n: f64, constant: &[f64]) -> DoubleDouble {
    constant.iter().fold(x, |rest, &part| {
        let (high, low) = two_product(-n, part);
        rest + DoubleDouble::normal(high, low)
    })
}

/// Returns `(e^r - 1, n)` with `x = n ln 2 + r`, `|r| <= ln(2)/2`.
fn reduced_exp_m1(x: DoubleDouble) -> (DoubleDouble, i32) {
    let n = (x.high * std::f64::consts::LOG2_E).round();
    let r = reduced(x, n, &LN_2);
    let series = (2..=EXP_TERMS).rev().fold(DoubleDouble::one(), |sum, k| {
        DoubleDouble::one() + r / DoubleDouble::from(f64::from(k)) * sum
    });
    (r * series, n as i32)
}

/// Returns `(sin x, cos x)`.
fn sin_cos(x: DoubleDouble) -> (DoubleDouble, DoubleDouble) {
    if x.is_zero() {
        return (x, DoubleDouble::one());
    }
    let n = (x.high * std::f64::consts::FRAC_2_PI).round();
    // Beyond 2^50, n would not be an exact integer.
    if x.high.is_nan() || x.high.abs() > 2.0_f64.powi(50) {
        return (DoubleDouble::from(f64::NAN), DoubleDouble::from(f64::NAN));
    }
    let r = reduced(x, n, &PI_2);
    let square = r * r;
    let series = |first: u32| {
        (1..=SIN_TERMS).rev().fold(DoubleDouble::one(), |sum, k| {
            let k = 2 * k + first;
            DoubleDouble::one() - square / DoubleDouble::from(f64::from(k * (k - 1))) * sum
        })
    };
    let (sin, cos) = (r * series(1), series(0));
    match (n as i64).rem_euclid(4) {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

impl Real for DoubleDouble {
    type Mask = bool;

    #[inline]
    fn lit(value: f64) -> Self {
        Self::from(value)
    }
    #[inline]
    fn primal(self) -> f64 {
        self.high
    }
    #[inline]
    fn less<T>(self, other: T) -> bool
    where
        Self: Accepts<T>,
    {
        let other = Self::accept(other);
        self < other
    }
    #[inline]
    fn less_equal<T>(self, other: T) -> bool
    where
        Self: Accepts<T>,
    {
        let other = Self::accept(other);
        self <= other
    }
    #[inline]
    fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
        if mask { if_true } else { if_false }
    }
    fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        if root == 0.0 || !root.is_finite() {
            return Self::from(root);
        }
        let (high, low) = two_product(root, root);
        let rest = self - Self::normal(high, low);
        Self::normal(root, rest.high / (2.0 * root))
    }
    fn exp(self) -> Self {
        if self.high.is_nan() {
            return self;
        }
        // Beyond this range the result is 0 or infinite.
        let (expm1, n) = reduced_exp_m1(self.clamp(Self::from(-800.0), Self::from(800.0)));
        (Self::one() + expm1).scaled(n)
    }
    /// Computes `ln x = k ln 2 + 2 atanh((m - 1) / (m + 1))`, where `x = 2^k m` and `m` is close to 1.
    fn ln(self) -> Self {
        if self.high <= 0.0 || !self.high.is_finite() {
            return Self::from(self.high.ln());
        }
        let k = self.high.log2().round();
        let m = self.scaled(-(k as i32));
        let s = (m - Self::one()) / (m + Self::one());
        let square = s * s;
        let series = (0..LN_TERMS).rev().fold(Self::zero(), |sum, j| {
            square * sum + Self::from(f64::from(2 * j + 1)).recip()
        });
        reduced((s + s) * series, -k, &LN_2)
    }
    fn sin(self) -> Self {
        sin_cos(self).0
    }
    fn cos(self) -> Self {
        sin_cos(self).1
    }
    /// Computes `tanh x = (e^2x - 1) / (e^2x + 1)`. The numerator is computed without cancellation.
    fn tanh(self) -> Self {
        // A zero keeps its sign.
        if self.is_zero() || !self.high.is_finite() {
            return Self::from(self.high.tanh());
        }
        // For arguments from 40 on, `1 - tanh x` is below 4e-35, so the argument may be clamped.
        let (expm1, n) = reduced_exp_m1((self + self).clamp(Self::from(-80.0), Self::from(80.0)));
        let numerator = expm1.scaled(n) + Self::new(2.0_f64.powi(n), -1.0);
        numerator / (numerator + Self::from(2.0))
    }
    /// Computes the angle in f64 with the system's function, and adds a correction: the small angle that remains after
    /// the point is turned back by the f64 angle.
    fn atan2<T>(self, x: T) -> Self
    where
        Self: Accepts<T>,
    {
        let x = Self::accept(x);
        let angle = self.high.atan2(x.high);
        // The sum below would lose the sign of a zero.
        if self.is_zero() && angle == 0.0 {
            return self;
        }
        let size = self.high.abs().max(x.high.abs());
        if size == 0.0 || size.is_infinite() || angle.is_nan() {
            // The angle is a multiple of pi/4 in these cases.
            let eighths = (angle / std::f64::consts::FRAC_PI_4).round();
            return Self::from(eighths) * Self::new(PI_2[0] / 2.0, PI_2[1] / 2.0);
        }
        let scale = Self::from(size);
        let (y, x) = (self / scale, x / scale);
        let (sin, cos) = sin_cos(Self::from(angle));
        // The quotient is about 1e-16. So its inverse tangent equals the quotient itself, up to 1e-48.
        Self::from(angle) + (y * cos - x * sin) / (x * cos + y * sin)
    }
    /// Computes the power by repeated squaring.
    fn powi(self, exponent: i32) -> Self {
        let power = by_squaring(Self::one(), self, exponent.unsigned_abs());
        if exponent < 0 { power.recip() } else { power }
    }
    /// Computes `e^(y ln x)`. If `x` is 0, infinite or NaN, the result is that of f64. If `x` is negative, the result
    /// is NaN.
    fn powf<T>(self, exponent: T) -> Self
    where
        Self: Accepts<T>,
    {
        let exponent = Self::accept(exponent);
        if self.high == 0.0 || !self.high.is_finite() {
            return Self::from(self.high.powf(exponent.high));
        }
        if self == Self::one() {
            return self;
        }
        (exponent * self.ln()).exp()
    }
    fn elementary(self, function: Elementary) -> Self {
        function.value(self)
    }
    #[inline]
    fn abs(self) -> Self {
        if self.high.is_sign_negative() {
            -self
        } else {
            self
        }
    }
    #[inline]
    fn detach(self) -> Self {
        self
    }
    #[inline]
    fn straight_through(self, _soft: Self) -> Self {
        self
    }
    #[inline]
    fn chain(partial: Self, cotangent: Self) -> Self {
        if cotangent.is_zero() {
            cotangent
        } else {
            partial * cotangent
        }
    }
}
