//! [`Element`] as num-traits' `Float`.

use std::num::FpCategory;

use num_traits::{Float, NumCast, ToPrimitive, Zero};

use super::element::Element;
use super::functions::{functions, steep_at_origin};
use super::number::decided;
use crate::math::rounding;
use crate::real::Real;

/// The conversions always return `None`, because a primitive number would lose the derivative.
impl<R: Real> ToPrimitive for Element<R> {
    fn to_i64(&self) -> Option<i64> {
        None
    }
    fn to_u64(&self) -> Option<u64> {
        None
    }
    fn to_f64(&self) -> Option<f64> {
        None
    }
}

/// Converts a number to a constant. The number is first converted to f64.
impl<R: Real> NumCast for Element<R> {
    fn from<T: ToPrimitive>(value: T) -> Option<Self> {
        value.to_f64().map(Self::lit)
    }
}

impl<R: Real> Element<R> {
    /// Makes a limit of the number range, such as the largest number. It is the limit of f64, or the limit of f32 if
    /// the inner type cannot hold numbers of f64.
    fn widest(double: f64, single: f32) -> Self {
        let wide = R::lit(double);
        let fits = wide.finite() & !wide.less_equal(R::zero());
        Self(R::select(fits, wide, R::lit(single.into())))
    }
}

impl<R: Real> Float for Element<R> {
    functions! {}
    functions! { of_reals }

    fn nan() -> Self {
        Self::lit(f64::NAN)
    }
    fn infinity() -> Self {
        Self::lit(f64::INFINITY)
    }
    fn neg_infinity() -> Self {
        Self::lit(f64::NEG_INFINITY)
    }
    fn neg_zero() -> Self {
        Self::lit(-0.0)
    }
    fn min_value() -> Self {
        -Self::max_value()
    }
    fn min_positive_value() -> Self {
        Self::widest(f64::MIN_POSITIVE, f32::MIN_POSITIVE)
    }
    fn max_value() -> Self {
        Self::widest(f64::MAX, f32::MAX)
    }
    fn epsilon() -> Self {
        Self(rounding::epsilon())
    }
    #[track_caller]
    fn is_nan(self) -> bool {
        self.partial_cmp(&self).is_none()
    }
    #[track_caller]
    fn is_infinite(self) -> bool {
        !self.is_finite() && !self.is_nan()
    }
    #[track_caller]
    fn is_finite(self) -> bool {
        decided::<R>(self.0.finite())
    }
    #[track_caller]
    fn is_normal(self) -> bool {
        self.classify() == FpCategory::Normal
    }
    #[track_caller]
    fn classify(self) -> FpCategory {
        let size = self.abs();
        if self.is_nan() {
            FpCategory::Nan
        } else if !self.is_finite() {
            FpCategory::Infinite
        } else if size >= Self::min_positive_value() {
            FpCategory::Normal
        } else if size > Self::zero() {
            FpCategory::Subnormal
        } else {
            FpCategory::Zero
        }
    }
    /// Returns the sign: 1, -1, or 0 at 0. (`f64::signum` returns 1 at 0.)
    #[track_caller]
    fn signum(self) -> Self {
        Self(self.0.signum())
    }
    #[track_caller]
    fn is_sign_positive(self) -> bool {
        !self.is_sign_negative()
    }
    #[track_caller]
    fn is_sign_negative(self) -> bool {
        decided::<R>(rounding::sign_bit(self.0))
    }
    #[track_caller]
    fn to_degrees(self) -> Self {
        self * Self(R::lit(180.0) / rounding::pi::<R>())
    }
    #[track_caller]
    fn to_radians(self) -> Self {
        self * Self(rounding::pi::<R>() / R::lit(180.0))
    }
    #[track_caller]
    fn abs_sub(self, other: Self) -> Self {
        Self(R::select(
            self.0.less_equal(other.0),
            R::zero(),
            self.0 - other.0,
        ))
    }
    /// # Panics
    /// Always, because a primitive number has no derivative.
    #[track_caller]
    fn integer_decode(self) -> (u64, i16, i8) {
        panic!(
            "an `Element` cannot be decoded, because its derivative would be lost; decode the primal of its field `.0`"
        )
    }
    #[track_caller]
    fn copysign(self, sign: Self) -> Self {
        if self.is_sign_negative() == sign.is_sign_negative() {
            self
        } else {
            -self
        }
    }
}
