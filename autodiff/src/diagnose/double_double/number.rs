//! The pair of floats and its arithmetic.

use std::cmp::Ordering;

use num_traits::FromPrimitive;

use crate::math::Primitive;
use crate::math::exact::{two_product, two_sum};
use crate::operators::{literal_operators, operators};
use crate::real::Real;

/// The unevaluated sum of two floats; see the [module](super).
///
/// The first float is the sum rounded to f64, so the pair is unique and compares part by part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoubleDouble {
    pub(super) high: f64,
    low: f64,
}

impl DoubleDouble {
    /// Returns the exact sum of two floats.
    #[inline]
    pub fn new(a: f64, b: f64) -> Self {
        let (high, low) = two_sum(a, b);
        Self::normal(high, low)
    }

    /// Returns the number rounded to f64, and the rest.
    #[inline]
    pub fn parts(self) -> [f64; 2] {
        [self.high, self.low]
    }

    /// Returns the number rounded to f64.
    #[inline]
    pub fn to_f64(self) -> f64 {
        self.high
    }

    /// `high + low`, where `low` is small compared to `high`. The second part of infinities and NaN is 0, and
    /// a zero keeps its sign.
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

    /// `self * 2^exponent`, exact except for over- and underflow.
    #[inline]
    pub(super) fn scaled(self, exponent: i32) -> Self {
        // Two factors, because 2^exponent itself may be out of range.
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
    // Not inlined: a kernel over duals of these would take seconds to compile.
    #[inline(never)]
    impl[] DoubleDouble:
    // Hida, Li and Bailey's accurate sum: the bound of 3 * 2^-106 holds under cancellation too.
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
    // Long division, with three floats of quotient.
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
