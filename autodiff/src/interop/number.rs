//! Implements arithmetic and comparison for elements, as num-traits needs them.

use std::cmp::Ordering;
use std::fmt;

use num_traits::{Float, Num, Signed, Zero};

use super::element::Element;
use crate::math::rounding::remainder;
use crate::operators::{
    closure_operators, constants_by_f64, literal_operators, operator, operators,
};
use crate::real::Real;
use crate::rule;

/// Returns the result of a comparison on which the calling code branches.
///
/// # Panics
/// If the result is not the same in all lanes.
#[track_caller]
pub(crate) fn decided<R: Real>(mask: R::Mask) -> bool {
    let Some(answer) = rule::uniform(mask) else {
        panic!("lanes would take different branches; evaluate the points one at a time")
    };
    answer
}

operators! {
    #[inline]
    impl[R: Real] Element<R>:
    a + b => Self(a.0 + b.0),
    a - b => Self(a.0 - b.0),
    a * b => Self(a.0 * b.0),
    a / b => Self(a.0 / b.0),
    -a => Self(-a.0),
    0 => Self(R::zero()),
    1 => Self(R::one()),
    // False for a number that carries a derivative: code that leaves out a zero would lose the derivative.
    a == 0 => a.0.is_zero(),
}

literal_operators! { [R: Real] Element<R> }

// Computes the remainder of a division whose quotient is an integer. The remainder is exact and has the sign of the
// dividend, like that of `%` for floats.
operator! {
    [#[inline]] [R: Real] Element<R>, Rem rem RemAssign rem_assign, a b Self(remainder(a.0, b.0))
}

impl<R: Real> Element<R> {
    /// Whether the primals are equal.
    #[inline]
    #[track_caller]
    pub(super) fn has_value_of(&self, other: &Self) -> bool {
        decided::<R>(self.0.less_equal(other.0)) && decided::<R>(other.0.less_equal(self.0))
    }

    /// Whether the number carries a derivative.
    #[inline]
    pub(super) fn moves(&self) -> bool {
        !R::zero().straight_through(self.0).is_zero()
    }
}

/// A number that carries a derivative never equals a constant: code that takes a shortcut at a constant would lose the
/// derivative.
impl<R: Real> PartialEq for Element<R> {
    #[inline]
    #[track_caller]
    fn eq(&self, other: &Self) -> bool {
        self.has_value_of(other) && self.moves() == other.moves()
    }
}

impl<R: Real> PartialOrd for Element<R> {
    #[inline]
    #[track_caller]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let below = decided::<R>(self.0.less_equal(other.0));
        let above = decided::<R>(other.0.less_equal(self.0));
        match (below, above) {
            (true, true) => Some(Ordering::Equal),
            (true, false) => Some(Ordering::Less),
            (false, true) => Some(Ordering::Greater),
            (false, false) => None,
        }
    }
    // The default methods would compare in a line of the standard library.
    #[inline]
    #[track_caller]
    fn lt(&self, other: &Self) -> bool {
        self.partial_cmp(other).is_some_and(Ordering::is_lt)
    }
    #[inline]
    #[track_caller]
    fn le(&self, other: &Self) -> bool {
        self.partial_cmp(other).is_some_and(Ordering::is_le)
    }
    #[inline]
    #[track_caller]
    fn gt(&self, other: &Self) -> bool {
        self.partial_cmp(other).is_some_and(Ordering::is_gt)
    }
    #[inline]
    #[track_caller]
    fn ge(&self, other: &Self) -> bool {
        self.partial_cmp(other).is_some_and(Ordering::is_ge)
    }
}

impl<R: Real> Num for Element<R> {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    /// Parses a number as f64 and makes it a constant.
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self::lit)
    }
}

impl<R: Real> Signed for Element<R> {
    #[track_caller]
    fn abs(&self) -> Self {
        Self(self.0.abs())
    }
    #[track_caller]
    fn abs_sub(&self, other: &Self) -> Self {
        Float::abs_sub(*self, *other)
    }
    #[track_caller]
    fn signum(&self) -> Self {
        Self(self.0.signum())
    }
    #[track_caller]
    fn is_positive(&self) -> bool {
        *self > Self::zero()
    }
    #[track_caller]
    fn is_negative(&self) -> bool {
        *self < Self::zero()
    }
}

constants_by_f64! { [R: Real] Element<R> }
closure_operators! { [R: Real] Element<R> }

impl<R: Real> fmt::Display for Element<R> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, formatter)
    }
}
