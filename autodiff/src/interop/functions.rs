//! The functions that num-traits' `Float` has in common with nalgebra's `ComplexField` and `RealField`.

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
        fn floor(self) -> Self {
            Self(rounding::floor(self.0))
        }
        fn ceil(self) -> Self {
            Self(-rounding::floor(-self.0))
        }
        fn round(self) -> Self {
            Self(rounding::round(self.0))
        }
        fn trunc(self) -> Self {
            Self(rounding::truncated(self.0))
        }
        fn fract(self) -> Self {
            self - self.trunc()
        }
        fn mul_add(self, factor: Self, term: Self) -> Self {
            Self(self.0.fma(factor.0, term.0))
        }
        fn powi(self, exponent: i32) -> Self {
            Self(self.0.powi(exponent))
        }
        fn powf(self, exponent: Self) -> Self {
            Self(self.0.powf(exponent.0))
        }
        fn exp2(self) -> Self {
            Self(R::lit(2.0).powf(self.0))
        }
        fn log(self, base: Self) -> Self {
            self.ln() / base.ln()
        }
        fn hypot(self, other: Self) -> Self {
            Self(self.0.hypot(other.0))
        }
        fn sin_cos(self) -> (Self, Self) {
            (self.sin(), self.cos())
        }
    };
    (of_reals) => {
        fn max(self, other: Self) -> Self {
            Self(self.0.max(other.0))
        }
        fn min(self, other: Self) -> Self {
            Self(self.0.min(other.0))
        }
        fn clamp(self, least: Self, most: Self) -> Self {
            Self(self.0.clamp(least.0, most.0))
        }
        fn atan2(self, x: Self) -> Self {
            Self(self.0.atan2(x.0))
        }
    };
    (methods [$($method:ident)*]) => {
        $(
            fn $method(self) -> Self {
                Self(self.0.$method())
            }
        )*
    };
}

pub(super) use functions;
