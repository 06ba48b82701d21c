//! Double-doubles as a [`Real`].

use num_traits::Zero;

use super::functions;
use super::number::DoubleDouble;
use crate::elementary::Elementary;
use crate::real::Real;

impl Real for DoubleDouble {
    type Mask = bool;

    #[inline]
    fn lit(value: f64) -> Self {
        Self::from(value)
    }
    #[inline]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline]
    fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
        if mask { if_true } else { if_false }
    }
    fn sqrt(self) -> Self {
        functions::sqrt(self)
    }
    fn exp(self) -> Self {
        functions::exp(self)
    }
    fn ln(self) -> Self {
        functions::ln(self)
    }
    fn sin(self) -> Self {
        functions::sin_cos(self).0
    }
    fn cos(self) -> Self {
        functions::sin_cos(self).1
    }
    fn tanh(self) -> Self {
        functions::tanh(self)
    }
    fn atan2(self, x: Self) -> Self {
        functions::atan2(self, x)
    }
    fn powi(self, exponent: i32) -> Self {
        functions::powi(self, exponent)
    }
    fn powf(self, exponent: Self) -> Self {
        functions::powf(self, exponent)
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
