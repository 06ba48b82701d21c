//! The function [`lit`], which makes constants in generic code.

use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::literal::Argument;
use crate::real::{Accepts, Literal, Mask, Real};

/// Makes a constant that can stand on either side of an operator in code over any [`Real`]: `lit(2.0) * x +
/// lit(1.0)`. An argument of a method is a plain float, `x.max(0.0)`. An initial value is [`R::lit(2.0)`](Real::lit).
///
/// ```
/// use autodiff::{Real, lit};
///
/// fn celsius<R: Real>(fahrenheit: R) -> R {
///     (fahrenheit - lit(32.0)) / lit(1.8)
/// }
/// assert_eq!(celsius(212.0), 100.0);
///
/// fn fall<R: Real>(time: R) -> R {
///     -lit(0.5 * 9.81) * time * time
/// }
/// assert_eq!(fall(2.0), -19.62);
/// ```
///
/// Literals have no operators between them: write `lit(0.5 * 9.81)`, not `lit(0.5) * lit(9.81)`.
#[inline(always)]
pub fn lit(value: f64) -> Literal {
    Literal(value)
}

#[diagnostic::do_not_recommend]
impl<R: Real> Argument for R {}

#[diagnostic::do_not_recommend]
impl<R: Real> Accepts<R> for R {
    #[inline(always)]
    #[track_caller]
    fn accept(argument: R) -> R {
        argument
    }
}

#[diagnostic::do_not_recommend]
impl<R: Real> Accepts<Literal> for R {
    #[inline(always)]
    #[track_caller]
    fn accept(argument: Literal) -> R {
        R::lit(argument.0)
    }
}

/// Returns a number as text for a message: its primal, or all lanes.
pub(crate) fn printed<R: Real>(number: R) -> String {
    if R::Mask::IS_SINGLE {
        format!("{:?}", number.primal())
    } else {
        format!("{number:?}")
    }
}

// A product of two literals would be a second implementation of `Mul`, and the compiler could no longer infer the result
// of `lit(2.0) * x` where the type of `x` is open.
impl Neg for Literal {
    type Output = Literal;
    #[inline(always)]
    #[track_caller]
    fn neg(self) -> Literal {
        Literal(-self.0)
    }
}

/// Implements the operators whose left operand is a literal: `literal op number`.
macro_rules! literal_first {
    ($($trait:ident $method:ident |$literal:ident, $number:ident| $result:expr),*) => {
        $(
            impl<R: Real> $trait<R> for Literal {
                type Output = R;
                #[inline(always)]
                #[track_caller]
                fn $method(self, $number: R) -> R {
                    let $literal = self.0;
                    $result
                }
            }
        )*
    };
}
literal_first! {
    Add add |literal, number| R::lit(literal) + number,
    Sub sub |literal, number| R::lit(literal) - number,
    Mul mul |literal, number| number.scale(literal),
    Div div |literal, number| R::lit(literal) / number
}
