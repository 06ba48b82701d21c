//! Implements the traits of simba, on which nalgebra is built, for [`Element`].

use approx::{AbsDiffEq, RelativeEq, UlpsEq};
use nalgebra::{ComplexField, Field, RealField, SimdValue};
use num_traits::{FloatConst, One, Zero};
use simba::scalar::SubsetOf;

use super::super::element::Element;
use super::super::functions::{functions, steep_at_origin};
use super::super::number::decided;
use crate::math::rounding;
use crate::real::{Mask, Real};

impl<R: Real> Field for Element<R> {}

/// For nalgebra, an element is a SIMD register with one lane. The lanes inside `R` are not visible to nalgebra.
#[allow(unsafe_code)] // Only the signatures of the trait are unsafe.
impl<R: Real> SimdValue for Element<R> {
    const LANES: usize = 1;
    type Element = Self;
    type SimdBool = bool;

    fn splat(value: Self) -> Self {
        value
    }
    fn extract(&self, _lane: usize) -> Self {
        *self
    }
    unsafe fn extract_unchecked(&self, _lane: usize) -> Self {
        *self
    }
    fn replace(&mut self, _lane: usize, value: Self) {
        *self = value;
    }
    unsafe fn replace_unchecked(&mut self, _lane: usize, value: Self) {
        *self = value;
    }
    fn select(self, condition: bool, other: Self) -> Self {
        if condition { self } else { other }
    }
}

impl<R: Real> SubsetOf<Self> for Element<R> {
    fn to_superset(&self) -> Self {
        *self
    }
    fn from_superset_unchecked(element: &Self) -> Self {
        *element
    }
    fn is_in_subset(_: &Self) -> bool {
        true
    }
}

/// Converts floats to constant elements. The other direction does not exist, because a float would lose the derivative.
macro_rules! constants_from {
    ($($float:ident)*) => {
        $(
            impl<R: Real> SubsetOf<Element<R>> for $float {
                fn to_superset(&self) -> Element<R> {
                    Element::lit((*self).into())
                }
                #[track_caller]
                fn from_superset_unchecked(_: &Element<R>) -> Self {
                    no_float()
                }
                #[track_caller]
                fn from_superset(_: &Element<R>) -> Option<Self> {
                    no_float()
                }
                fn is_in_subset(_: &Element<R>) -> bool {
                    false
                }
            }
        )*
    };
}
constants_from! { f64 f32 }

#[track_caller]
fn no_float() -> ! {
    panic!(
        "an `Element` cannot be converted to a float, because its derivative would be lost; to get only the \
         value, take the primal of its field `.0`; for a matrix exponential, call `autodiff::matrices::exp`"
    )
}

impl<R: Real> AbsDiffEq for Element<R> {
    type Epsilon = Self;
    fn default_epsilon() -> Self {
        Self(rounding::epsilon())
    }
    #[track_caller]
    fn abs_diff_eq(&self, other: &Self, epsilon: Self) -> bool {
        decided::<R>((self.0 - other.0).abs().less_equal(epsilon.0)) || self.has_value_of(other)
    }
}

impl<R: Real> RelativeEq for Element<R> {
    fn default_max_relative() -> Self {
        Self::default_epsilon()
    }
    #[track_caller]
    fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
        let largest = self.0.abs().max(other.0.abs());
        // An infinite number must equal only itself. Every number would be within a multiple of infinity, so the
        // relative tolerance is 0 in this case.
        let largest = R::select(largest.finite(), largest, R::zero());
        self.abs_diff_eq(other, epsilon) || self.abs_diff_eq(other, Self(largest) * max_relative)
    }
}

impl<R: Real> UlpsEq for Element<R> {
    fn default_max_ulps() -> u32 {
        f64::default_max_ulps()
    }
    /// Compares with a tolerance in ulps. One ulp is taken to be the larger of the two numbers times the type's
    /// epsilon.
    #[track_caller]
    fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
        let ulps = Self::lit(max_ulps.into()) * Self::default_epsilon();
        self.relative_eq(other, epsilon, ulps)
    }
}

impl<R: Real> ComplexField for Element<R> {
    type RealField = Self;

    functions! {}

    fn from_real(real: Self) -> Self {
        real
    }
    fn real(self) -> Self {
        self
    }
    fn imaginary(self) -> Self {
        Self::zero()
    }
    #[track_caller]
    fn modulus(self) -> Self {
        Self(self.0.abs())
    }
    #[track_caller]
    fn modulus_squared(self) -> Self {
        self * self
    }
    #[track_caller]
    fn argument(self) -> Self {
        if self < Self::zero() {
            Self::pi()
        } else {
            Self::zero()
        }
    }
    #[track_caller]
    fn norm1(self) -> Self {
        self.modulus()
    }
    #[track_caller]
    fn scale(self, factor: Self) -> Self {
        self * factor
    }
    #[track_caller]
    fn unscale(self, factor: Self) -> Self {
        self / factor
    }
    /// Returns the magnitude and the sign. The sign is a constant, and is 1 for zero.
    ///
    /// # Panics
    /// If the number is NaN. nalgebra's factorisations call this method, and their iterations would never end.
    #[track_caller]
    fn to_exp(self) -> (Self, Self) {
        let number = self.0.less_equal(self.0);
        assert!(
            number.any(),
            "nalgebra's factorisation met NaN: an entry is NaN, or a row or a column of zeros carries derivatives; \
             call `inverse`, `solve`, `symmetric_eigen` or `singular_values` of `autodiff::matrices`"
        );
        if self < Self::zero() {
            (-self, -Self::one())
        } else {
            (self, Self::one())
        }
    }
    fn conjugate(self) -> Self {
        self
    }
    #[track_caller]
    fn sinc(self) -> Self {
        Self(self.0.sinc())
    }
    #[track_caller]
    fn sinhc(self) -> Self {
        Self(self.0.sinhc())
    }
    #[track_caller]
    fn powc(self, exponent: Self) -> Self {
        self.powf(exponent)
    }
    #[track_caller]
    fn is_finite(&self) -> bool {
        decided::<R>(self.0.finite())
    }
    /// Returns the square root, or `None` for zero and for negative numbers. At zero the root has no finite derivative.
    #[track_caller]
    fn try_sqrt(self) -> Option<Self> {
        if self > Self::zero() {
            Some(self.sqrt())
        } else {
            None
        }
    }
}

/// Defines nalgebra's methods for constants, such as `pi()`.
macro_rules! constants {
    ($($name:ident $constant:ident),*) => {
        $(
            fn $name() -> Self {
                <Self as FloatConst>::$constant()
            }
        )*
    };
}

impl<R: Real> RealField for Element<R> {
    functions! { of_reals }
    #[track_caller]
    fn is_sign_positive(&self) -> bool {
        !self.is_sign_negative()
    }
    #[track_caller]
    fn is_sign_negative(&self) -> bool {
        decided::<R>(rounding::sign_bit(self.0))
    }
    #[track_caller]
    fn copysign(self, sign: Self) -> Self {
        num_traits::Float::copysign(self, sign)
    }
    fn min_value() -> Option<Self> {
        Some(<Self as num_traits::Float>::min_value())
    }
    fn max_value() -> Option<Self> {
        Some(<Self as num_traits::Float>::max_value())
    }
    constants! {
        pi PI, two_pi TAU, frac_pi_2 FRAC_PI_2, frac_pi_3 FRAC_PI_3, frac_pi_4 FRAC_PI_4,
        frac_pi_6 FRAC_PI_6, frac_pi_8 FRAC_PI_8, frac_1_pi FRAC_1_PI, frac_2_pi FRAC_2_PI,
        frac_2_sqrt_pi FRAC_2_SQRT_PI, e E, log2_e LOG2_E, log10_e LOG10_E, ln_2 LN_2, ln_10 LN_10
    }
}
