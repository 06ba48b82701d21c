//! Implements num-traits' constants for [`Element`].

use std::f64::consts;

use num_traits::FloatConst;

use super::element::Element;
use crate::math::rounding;
use crate::real::Real;

/// Returns a constant that is given as an f64 plus its rounding error. [`DoubleDouble`](crate::DoubleDouble) keeps
/// both.
fn constant<R: Real>(digits: f64, more: f64) -> Element<R> {
    Element(R::lit(digits) + R::lit(more))
}

/// Defines a method for each constant, from the rounding error of its f64. The rounding errors were computed with
/// mpmath.
macro_rules! constants {
    ($($name:ident $rest:literal)*) => {
        $(
            fn $name() -> Self {
                constant(consts::$name, $rest)
            }
        )*
    };
}

/// The constants are exact to the last digit of each number type.
impl<R: Real> FloatConst for Element<R> {
    constants! {
        E 1.4456468917292502e-16
        FRAC_1_PI -1.9678676675182486e-17
        FRAC_1_SQRT_2 -4.833646656726457e-17
        FRAC_2_PI -3.935735335036497e-17
        FRAC_2_SQRT_PI 1.533545961316588e-17
        FRAC_PI_2 6.123233995736766e-17
        FRAC_PI_3 -1.072081766451091e-16
        FRAC_PI_4 3.061616997868383e-17
        FRAC_PI_6 -5.360408832255455e-17
        FRAC_PI_8 1.5308084989341915e-17
        LN_10 -2.1707562233822494e-16
        LN_2 2.3190468138462996e-17
        LOG10_E 1.098319650216765e-17
        LOG2_E 2.0355273740931033e-17
        SQRT_2 -9.667293313452913e-17
        TAU 2.4492935982947064e-16
        LOG10_2 -2.8037281277851704e-18
        LOG2_10 1.661617516973592e-16
    }
    fn PI() -> Self {
        Self(rounding::pi())
    }
}
