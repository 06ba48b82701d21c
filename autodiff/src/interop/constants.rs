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

#[cfg(test)]
mod tests {
    use num_traits::{Float, FloatConst};

    use crate::{DoubleDouble, Element, Real, gradient};

    /// Returns the errors of the constants: each one is compared with the value of a formula, such as `sqrt(2)`.
    fn misfits<F: Float + FloatConst>() -> Vec<F> {
        let number = |x: f64| F::from(x).unwrap_or_else(F::nan);
        let (two, ten) = (number(2.0), number(10.0));
        vec![
            F::E() - F::one().exp(),
            F::PI() - number(4.0) * F::one().atan(),
            F::TAU() - two * F::PI(),
            F::FRAC_1_PI() - F::PI().recip(),
            F::FRAC_2_PI() - two / F::PI(),
            F::FRAC_2_SQRT_PI() - two / F::PI().sqrt(),
            F::FRAC_PI_2() - F::PI() / two,
            F::FRAC_PI_3() - F::PI() / number(3.0),
            F::FRAC_PI_4() - F::PI() / number(4.0),
            F::FRAC_PI_6() - F::PI() / number(6.0),
            F::FRAC_PI_8() - F::PI() / number(8.0),
            F::SQRT_2() - two.sqrt(),
            F::FRAC_1_SQRT_2() - two.sqrt().recip(),
            F::LN_2() - two.ln(),
            F::LN_10() - ten.ln(),
            F::LOG2_E() - two.ln().recip(),
            F::LOG10_E() - ten.ln().recip(),
            F::LOG10_2() - two.ln() / ten.ln(),
            F::LOG2_10() - ten.ln() / two.ln(),
        ]
    }

    #[test]
    fn constants_have_all_digits_that_a_number_has() {
        // The formulas are two operations on numbers up to 7, each with an error of 1e-32 in double-double.
        let wide = misfits::<Element<DoubleDouble>>();
        let off = |x: &Element<DoubleDouble>| x.0.abs().less(DoubleDouble::lit(3e-31));
        assert!(wide.iter().all(off), "{wide:?}");
        // The formulas are functions of numbers up to 7, with errors of an ulp or two.
        let floats = misfits::<Element<f64>>();
        assert!(floats.iter().all(|x| x.0.abs() < 4e-15), "{floats:?}");
        assert_eq!(Element::<f64>::PI().0, std::f64::consts::PI);
        assert_eq!(Element::<f64>::LOG2_10().0, std::f64::consts::LOG2_10);
        assert_eq!(Element::<f32>::PI().0, std::f32::consts::PI);
    }

    #[test]
    fn sums_and_products_are_differentiated() {
        fn spread<T: Float + std::iter::Sum + for<'a> std::iter::Product<&'a T>>(x: &[T]) -> T {
            x.iter().copied().sum::<T>() * x.iter().product::<T>()
        }
        let slope = gradient(
            |x| spread(&x.iter().map(|&x| Element(x)).collect::<Vec<_>>()).0,
            &[2.0, 3.0],
        );
        // The function is (x + y) x y. Its slopes are 2 x y + y^2 and x^2 + 2 x y.
        assert_eq!(slope, [21.0, 16.0]);
    }
}
