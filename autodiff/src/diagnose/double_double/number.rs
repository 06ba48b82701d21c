//! The pair of floats and its arithmetic.

use std::cmp::Ordering;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use num_traits::{FromPrimitive, One, Zero};

use super::exact::{two_product, two_sum};
use crate::math::Primitive;

/// The unevaluated sum of two floats; see the [module](super).
///
/// The first is the sum rounded to f64, so the pair is unique and compares part by part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wide {
    pub(super) high: f64,
    low: f64,
}

impl Wide {
    /// The sum of two floats, exactly.
    #[inline]
    pub fn new(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        Self::normal(high, low)
    }

    /// The number rounded to f64, and what is left.
    #[inline]
    pub fn parts(self) -> [f64; 2] {
        [self.high, self.low]
    }

    /// The number rounded to f64.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.high
    }

    /// `high + low`, where `low` is small beside `high`. Infinities and NaN have no second part, and a
    /// zero keeps its sign.
    #[inline]
    pub(super) fn normal(high: f64, low: f64) -> Self {
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

    /// `self * 2^exponent`, exactly but for over- and underflow.
    #[inline]
    pub(super) fn scaled(self, exponent: i32) -> Self {
        // Two factors: 2^exponent itself may lie outside the range.
        let half = exponent / 2;
        let [a, b] = [half, exponent - half].map(|n| 2.0_f64.powi(n));
        Self::normal(self.high * a * b, self.low * a * b)
    }
}

/// Exact.
impl From<f64> for Wide {
    #[inline]
    fn from(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }
}

/// Rounded.
impl From<Wide> for f64 {
    #[inline]
    fn from(value: Wide) -> Self {
        value.high
    }
}

/// Hida, Li and Bailey's accurate sum: the bound of 3 * 2^-106 holds under cancellation too.
impl Add for Wide {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        let (high, low) = two_sum(self.high, other.high);
        let (next, last) = two_sum(self.low, other.low);
        let sum = Self::normal(high, low + next);
        Self::normal(sum.high, sum.low + last)
    }
}

impl Sub for Wide {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let (high, low) = two_product(self.high, other.high);
        let cross = Primitive::mul_add(self.low, other.high, self.low * other.low);
        Self::normal(high, low + Primitive::mul_add(self.high, other.low, cross))
    }
}

/// Long division, with three floats of quotient.
impl Div for Wide {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        if first == 0.0 || !first.is_finite() {
            return Self::from(first);
        }
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        Self::normal(first, second) + Self::from(rest.high / other.high)
    }
}

impl Neg for Wide {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl AddAssign for Wide {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Wide {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Wide {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl DivAssign for Wide {
    #[inline]
    fn div_assign(&mut self, other: Self) {
        *self = *self / other;
    }
}

impl Zero for Wide {
    #[inline]
    fn zero() -> Self {
        Self::from(0.0)
    }
    #[inline]
    fn is_zero(&self) -> bool {
        self.high == 0.0
    }
}

impl One for Wide {
    #[inline]
    fn one() -> Self {
        Self::from(1.0)
    }
}

impl Sum for Wide {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::zero(), |sum, term| sum + term)
    }
}

impl PartialOrd for Wide {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

impl FromPrimitive for Wide {
    fn from_i64(value: i64) -> Option<Self> {
        Self::from_i128(value.into())
    }
    fn from_u64(value: u64) -> Option<Self> {
        Self::from_i128(value.into())
    }
    /// Exactly, for all integers of 64 bits.
    fn from_i128(value: i128) -> Option<Self> {
        let high = value as f64;
        Some(Self::new(high, (value - high as i128) as f64))
    }
    fn from_f64(value: f64) -> Option<Self> {
        Some(Self::from(value))
    }
}
