//! The number type on which a sparsity pattern is traced.

use std::fmt;
use std::ops::{BitAnd, BitOr, Not};

use crate::elementary::Elementary;
use crate::operators::{literal_operators, operators};
use crate::real::{Accepts, Mask, Real};

/// A float whose comparisons are undecided: a recording of `Var<Undecided>` keeps both operands of `select`, `max`, `min`
/// and `clamp`. Apart from that it is an `f64`. [`Pattern::traced`](super::sparse::Pattern::traced) runs its function on
/// it.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Undecided(f64);

/// The result of a comparison at the point where a function is traced. At another point it may be the opposite.
#[derive(Clone, Copy, Debug)]
pub struct Open(bool);

impl BitAnd for Open {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Open {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Open {
    type Output = Self;
    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// Loops that wait for a mask end as on floats, because `any` tells the result at this point.
impl Mask for Open {
    const KEEPS_BOTH: bool = true;
    fn splat(value: bool) -> Self {
        Self(value)
    }
    fn any(self) -> bool {
        self.0
    }
}

impl fmt::Display for Undecided {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}

/// Implements methods of [`Real`] by those of `f64`: with one operand, and with two.
macro_rules! methods {
    ([$($of_one:ident)*] [$($of_two:ident)*]) => {
        $(fn $of_one(self) -> Self {
            Self(Real::$of_one(self.0))
        })*
        $(fn $of_two<T>(self, other: T) -> Self
        where
            Self: Accepts<T>,
        {
            Self(Real::$of_two(self.0, Self::accept(other).0))
        })*
    };
}

impl Real for Undecided {
    type Mask = Open;

    methods! { [sqrt exp ln sin cos tanh abs] [atan2 powf] }

    fn lit(value: f64) -> Self {
        Self(value)
    }
    fn primal(self) -> f64 {
        self.0
    }
    fn less<T>(self, other: T) -> Open
    where
        Self: Accepts<T>,
    {
        Open(self < Self::accept(other))
    }
    fn less_equal<T>(self, other: T) -> Open
    where
        Self: Accepts<T>,
    {
        Open(self <= Self::accept(other))
    }
    fn select(mask: Open, if_true: Self, if_false: Self) -> Self {
        if mask.0 { if_true } else { if_false }
    }
    fn powi(self, exponent: i32) -> Self {
        Self(Real::powi(self.0, exponent))
    }
    fn elementary(self, function: Elementary) -> Self {
        Self(self.0.elementary(function))
    }
    fn detach(self) -> Self {
        self
    }
    fn straight_through(self, _soft: Self) -> Self {
        self
    }
    fn chain(partial: Self, cotangent: Self) -> Self {
        Self(Real::chain(partial.0, cotangent.0))
    }
}

operators! {
    impl[] Undecided:
    a + b => Self(a.0 + b.0),
    a - b => Self(a.0 - b.0),
    a * b => Self(a.0 * b.0),
    a / b => Self(a.0 / b.0),
    -a => Self(-a.0),
    0 => Self(0.0),
    1 => Self(1.0),
    a == 0 => a.0 == 0.0,
}

literal_operators! { [] Undecided }
