//! The number type [`DoubleDouble`] and its arithmetic. Its other functions are in the module `diagnose`, because they
//! use the table of elementary functions.

use std::cmp::Ordering;

use num_traits::FromPrimitive;

use super::exact::{two_product, two_sum};
use super::primitive::Primitive;
use crate::operators::{literal_operators, operators};
use crate::real::Real;

/// Double-double numbers: a [`Real`](crate::Real) of about 31 digits, which shows rounding errors.
///
/// A program written over `R: Real` runs on [`DoubleDouble`] unchanged. The difference between its result in f64 and
/// its result in double-double is the rounding error of the f64 result. Inside [`Dual`](crate::Dual),
/// [`Var`](crate::Var) or a `Rollout` of `autodiff_programs` it measures the rounding errors of derivatives in the same way.
/// Double-double is about thirty times slower than f64.
///
/// ```
/// use autodiff::{DoubleDouble, Real};
///
/// fn thousand<R: Real>(x: R) -> R {
///     (0..1000).fold(R::zero(), |sum, _| sum + x)
/// }
///
/// let error = DoubleDouble::from(thousand(0.1)) - thousand(DoubleDouble::from(0.1));
/// // A thousand additions, each of which may round by half an ulp of 100: 1000 * 7e-15.
/// assert!(1e-12 < error.abs().to_f64() && error.abs().to_f64() < 7e-12);
/// ```
///
/// # Accuracy
///
/// `tests/double_double.rs` checks these relative errors against 50-digit values, for magnitudes between 1e-280 and
/// 1e300. Below 1e-280 the numbers are less accurate, because their second float underflows.
///
/// - 1e-31 for `+ - * /` and `sqrt`;
/// - 1e-30 for `exp`, `ln`, `tanh`, `atan2`, and for `sin` and `cos` away from their zeros. At a zero the error is
///   absolute, 1e-32 times the angle;
/// - 1e-29 for the special functions away from their zeros. For `erfc(x)` below 0.1 it is 1e-28 plus `x^2` times 1e-31;
/// - For `powi(n)` the error grows by `n` times 1e-31, and for `powf(y)` by `y ln x` times 1e-31.
///
/// `sin` and `cos` beyond 2^50 radians are NaN. So is `powf` of a negative number, even for an integer exponent.
/// Infinities, NaN and the conventions of the table in [`real`](crate::real) are as in f64.
///
/// Literals are f64: `R::lit(0.1)` is the same number in f64 and in double-double, so the two results differ only by
/// rounding errors.
///
/// # Representation
///
/// A number is the unevaluated sum of two floats. The first float is the sum rounded to f64. So each number has only one
/// pair, and numbers are compared part by part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble {
    pub(crate) high: f64,
    low: f64,
}

impl DoubleDouble {
    /// Returns the exact sum of two floats.
    #[inline]
    pub fn new(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        Self::normal(high, low)
    }

    /// Returns the two floats of which the number consists: the number rounded to f64, and the remainder.
    #[inline]
    pub fn parts(self) -> [f64; 2] {
        [self.high, self.low]
    }

    /// Returns the number rounded to f64.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.high
    }

    /// Returns `high + low`, where `low` is small compared to `high`. For infinities and NaN the second float is 0. A
    /// zero keeps its sign.
    #[inline]
    pub(crate) fn normal(high: f64, low: f64) -> Self {
        if low == 0.0 || !high.is_finite() {
            return Self { high, low: 0.0 };
        }
        let sum = high + low;
        if sum.is_infinite() {
            return Self {
                high: sum,
                low: 0.0,
            };
        }
        Self {
            high: sum,
            low: low - (sum - high),
        }
    }

    /// Returns `self * 2^exponent`. The result is exact unless it over- or underflows.
    #[inline]
    pub(crate) fn scaled(self, exponent: i32) -> Self {
        // The exponent is split over two factors, because 2^exponent itself may be out of range.
        let half = exponent / 2;
        let [a, b] = [half, exponent - half].map(|n| 2.0_f64.powi(n));
        Self::normal(self.high * a * b, self.low * a * b)
    }
}

/// The conversion is exact.
impl From<f64> for DoubleDouble {
    #[inline]
    fn from(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }
}

/// The conversion rounds to the nearest float.
impl From<DoubleDouble> for f64 {
    #[inline]
    fn from(value: DoubleDouble) -> Self {
        value.high
    }
}

operators! {
    // The operators are not inlined, because a kernel over duals of double-doubles would then take seconds to compile.
    #[inline(never)]
    impl[] DoubleDouble:
    // The accurate sum of Hida, Li and Bailey. Its error stays below 3 * 2^-106 even if the terms cancel.
    a + b => {
        let (high, low) = two_sum(a.high, b.high);
        let (next, last) = two_sum(a.low, b.low);
        let sum = Self::normal(high, low + next);
        Self::normal(sum.high, sum.low + last)
    },
    a - b => a + -b,
    a * b => {
        let (high, low) = two_product(a.high, b.high);
        let cross = Primitive::mul_add(a.low, b.high, a.low * b.low);
        Self::normal(high, low + Primitive::mul_add(a.high, b.low, cross))
    },
    // Long division. The quotient is computed as a sum of three floats.
    a / b => {
        let first = a.high / b.high;
        if first == 0.0 || !first.is_finite() {
            return Self::from(first);
        }
        let rest = a - b * Self::from(first);
        let second = rest.high / b.high;
        let rest = rest - b * Self::from(second);
        Self::normal(first, second) + Self::from(rest.high / b.high)
    },
    -a => Self {
        high: -a.high,
        low: -a.low,
    },
    0 => Self::from(0.0),
    1 => Self::from(1.0),
    a == 0 => a.high == 0.0,
}

literal_operators! { [] DoubleDouble }

impl PartialOrd for DoubleDouble {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

impl FromPrimitive for DoubleDouble {
    fn from_i64(value: i64) -> Option<Self> {
        Self::from_i128(value.into())
    }
    fn from_u64(value: u64) -> Option<Self> {
        Self::from_i128(value.into())
    }
    /// The conversion is exact for all integers of 64 bits.
    fn from_i128(value: i128) -> Option<Self> {
        let high = value as f64;
        Some(Self::new(high, (value - high as i128) as f64))
    }
    fn from_f64(value: f64) -> Option<Self> {
        Some(Self::from(value))
    }
}
