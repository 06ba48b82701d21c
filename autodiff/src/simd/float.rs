//! Implements [`Real`] for plain floats.

use crate::elementary::Elementary;
use crate::math::{self, OnFloats};
use crate::operators::literal_operators;
use crate::real::{Accepts, Real, Vectorized};

macro_rules! impl_real_for_float {
    ($float:ident, $lanes:ident, $needed:ident, $functions:ident) => {
        impl Real for $float {
            type Mask = bool;
            const KERNELS_NEED_LANES: bool = super::enter::$needed;
            const IS_FLOAT: bool = true;

            #[inline(always)]
            fn lit(value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn primal(self) -> f64 {
                self.into()
            }
            #[inline(always)]
            fn less<T>(self, other: T) -> bool
            where
                Self: Accepts<T>,
            {
                let other = Self::accept(other);
                self < other
            }
            #[inline(always)]
            fn less_equal<T>(self, other: T) -> bool
            where
                Self: Accepts<T>,
            {
                let other = Self::accept(other);
                self <= other
            }
            #[inline(always)]
            fn select(mask: bool, if_true: Self, if_false: Self) -> Self {
                if mask { if_true } else { if_false }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn exp(self) -> Self {
                math::$functions::exp(self)
            }
            #[inline(always)]
            fn ln(self) -> Self {
                self.ln()
            }
            #[inline(always)]
            fn sin(self) -> Self {
                math::$functions::sin_cos(self).0
            }
            #[inline(always)]
            fn cos(self) -> Self {
                math::$functions::sin_cos(self).1
            }
            #[inline(always)]
            fn sin_cos(self) -> (Self, Self) {
                math::$functions::sin_cos(self)
            }
            #[inline(always)]
            fn tan(self) -> Self {
                let (sin, cos) = math::$functions::sin_cos(self);
                sin / cos
            }
            #[inline(always)]
            fn tanh(self) -> Self {
                math::$functions::tanh(self)
            }
            #[inline(always)]
            fn atan2<T>(self, x: T) -> Self
            where
                Self: Accepts<T>,
            {
                self.atan2(Self::accept(x))
            }
            #[inline(always)]
            fn powi(self, exponent: i32) -> Self {
                math::powi(self as f64, exponent) as $float
            }
            #[inline(always)]
            fn powf<T>(self, exponent: T) -> Self
            where
                Self: Accepts<T>,
            {
                self.powf(Self::accept(exponent))
            }
            #[inline(always)]
            fn elementary(self, function: Elementary) -> Self {
                match function.on_floats(self) {
                    OnFloats::Formula(value) => value,
                    OnFloats::Function(of_f64) => of_f64(self as f64) as $float,
                }
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn detach(self) -> Self {
                self
            }
            #[inline(always)]
            fn straight_through(self, _soft: Self) -> Self {
                self
            }
            #[inline(always)]
            fn chain(partial: Self, cotangent: Self) -> Self {
                if cotangent == 0.0 {
                    0.0
                } else {
                    partial * cotangent
                }
            }
            #[inline(always)]
            fn vectorize<V: Vectorized<Self>>(work: V) -> V::Output {
                super::enter::$lanes(work)
            }
        }
    };
}

literal_operators! { @operators [] f64, |a, b| a * b }
literal_operators! { [] f32 }
impl_real_for_float!(f64, f64_lanes, F64_NEEDS_LANES, double);
impl_real_for_float!(f32, f32_lanes, F32_NEEDS_LANES, single);
