//! Computes the operations of a recording, with numbers of any type. A mask is represented by a number: 1 for true, 0
//! for false.

use autodiff::Real;
use autodiff::internal::{functions, rule};

use super::operation::{Binary, Logic, Unary};

/// Converts a number to the mask that it represents.
#[inline(always)]
pub(crate) fn holds<L: Real>(mask: L) -> L::Mask {
    L::lit(0.5).less(mask)
}

/// Converts a mask to the number that represents it.
#[inline(always)]
pub(crate) fn number<L: Real>(mask: L::Mask) -> L {
    L::select(mask, L::one(), L::zero())
}

#[inline(always)]
pub(crate) fn logic<L: Real>(f: Logic, a: L, b: L) -> L {
    let mask = match f {
        Logic::Less => a.less(b),
        Logic::LessEqual => a.less_equal(b),
        Logic::And => holds(a) & holds(b),
        Logic::Or => holds(a) | holds(b),
        Logic::Not => !holds(a),
    };
    number(mask)
}

macro_rules! define {
    (basic { $($method:ident $Basic:ident),* } composed { $($_composed:tt)* }) => {
        /// Returns the value of a function of one number, without its partial.
        #[inline(always)]
        pub(crate) fn unary_value<L: Real>(f: Unary, x: L) -> L {
            match f {
                Unary::Neg => -x,
                Unary::Abs => x.abs(),
                Unary::Detach => x.detach(),
                Unary::Powi(exponent) => x.powi(exponent),
                Unary::Elementary(function) => x.elementary(function),
                $(Unary::$Basic => x.$method(),)*
            }
        }

        /// Returns the value of a function of one number and its partial.
        #[inline(always)]
        pub(crate) fn unary<L: Real>(f: Unary, x: L) -> (L, L) {
            match f {
                Unary::Neg => (-x, -L::one()),
                Unary::Abs => rule::abs(x),
                Unary::Detach => (x.detach(), L::zero()),
                Unary::Powi(exponent) => rule::powi(x, exponent),
                Unary::Elementary(function) => function.rule(x),
                $(Unary::$Basic => rule::$method(x),)*
            }
        }
    };
}

functions!(define);

/// Returns the value of a function of two numbers, without its partials.
#[inline(always)]
pub(crate) fn binary_value<L: Real>(f: Binary, a: L, b: L) -> L {
    match f {
        Binary::Add => a + b,
        Binary::Sub => a - b,
        Binary::Mul => a * b,
        Binary::Div => a / b,
        Binary::Atan2 => a.atan2(b),
        Binary::Powf => a.powf(b),
        Binary::Hypot => a.hypot(b),
        Binary::Chain => L::chain(a, b),
        Binary::StraightThrough => a.straight_through(b),
    }
}

/// Returns the value of a function of two numbers and its partials.
#[inline(always)]
pub(crate) fn binary<L: Real>(f: Binary, a: L, b: L) -> (L, [L; 2]) {
    let one = L::one();
    match f {
        Binary::Add => (a + b, [one, one]),
        Binary::Sub => (a - b, [one, -one]),
        Binary::Mul => rule::mul(a, b),
        Binary::Div => rule::div(a, b),
        Binary::Atan2 => rule::atan2(a, b),
        Binary::Powf => rule::powf(a, b),
        Binary::Hypot => rule::hypot(a, b),
        Binary::Chain => (L::chain(a, b), [b, a]),
        Binary::StraightThrough => (a.straight_through(b), [L::zero(), one]),
    }
}
