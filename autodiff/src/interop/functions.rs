//! The functions that num-traits' `Float` has in common with nalgebra's `ComplexField` and `RealField`.

use crate::real::{Mask, Real};

/// Returns the value of a function of a point in the plane, with slopes that are NaN at the origin. Roots and logarithms
/// of complex numbers are computed from the length and the angle of a point. With the slopes of [`Real::hypot`] and
/// [`Real::atan2`], which are 0 at the origin, forward mode would return 0 for the slopes of a root there.
#[inline]
#[track_caller]
pub(super) fn steep_at_origin<R: Real>(value: R, [x, y]: [R; 2]) -> R {
    let [at_x, at_y] = [x, y].map(|x| x.detach().abs());
    // Unlike the larger one, the sum is NaN if either number is.
    let origin = (at_x + at_y).less_equal(R::zero());
    if R::Mask::IS_SINGLE && !origin.any() {
        return value;
    }
    let unknown = R::lit(f64::NAN);
    R::select(
        origin,
        value.straight_through(x * unknown + y * unknown),
        value,
    )
}

/// Defines the methods that the traits `Float` and `ComplexField` share. With the argument `of_reals`, defines the
/// methods that `Float` and `RealField` share.
macro_rules! functions {
    () => {
        $crate::interop::functions::functions! {
            methods [
                abs recip sqrt exp ln sin cos tan tanh asin acos atan sinh cosh asinh acosh atanh exp_m1 ln_1p
                log2 log10 cbrt
            ]
        }
        #[track_caller]
        fn floor(self) -> Self {
            Self(rounding::floor(self.0))
        }
        #[track_caller]
        fn ceil(self) -> Self {
            Self(-rounding::floor(-self.0))
        }
        #[track_caller]
        fn round(self) -> Self {
            Self(rounding::round(self.0))
        }
        #[track_caller]
        fn trunc(self) -> Self {
            Self(rounding::truncated(self.0))
        }
        #[track_caller]
        fn fract(self) -> Self {
            self - self.trunc()
        }
        #[track_caller]
        fn mul_add(self, factor: Self, term: Self) -> Self {
            Self(self.0.fma(factor.0, term.0))
        }
        #[track_caller]
        fn powi(self, exponent: i32) -> Self {
            Self(self.0.powi(exponent))
        }
        #[track_caller]
        fn powf(self, exponent: Self) -> Self {
            Self(self.0.powf(exponent.0))
        }
        #[track_caller]
        fn exp2(self) -> Self {
            Self(R::lit(2.0).powf(self.0))
        }
        #[track_caller]
        fn log(self, base: Self) -> Self {
            self.ln() / base.ln()
        }
        #[track_caller]
        fn hypot(self, other: Self) -> Self {
            Self(steep_at_origin(self.0.hypot(other.0), [self.0, other.0]))
        }
        #[track_caller]
        fn sin_cos(self) -> (Self, Self) {
            (self.sin(), self.cos())
        }
    };
    (of_reals) => {
        #[track_caller]
        fn max(self, other: Self) -> Self {
            Self(self.0.max(other.0))
        }
        #[track_caller]
        fn min(self, other: Self) -> Self {
            Self(self.0.min(other.0))
        }
        #[track_caller]
        fn clamp(self, least: Self, most: Self) -> Self {
            Self(self.0.clamp(least.0, most.0))
        }
        #[track_caller]
        fn atan2(self, x: Self) -> Self {
            Self(steep_at_origin(self.0.atan2(x.0), [self.0, x.0]))
        }
    };
    (methods [$($method:ident)*]) => {
        $(
            #[track_caller]
            fn $method(self) -> Self {
                Self(self.0.$method())
            }
        )*
    };
}

pub(super) use functions;
