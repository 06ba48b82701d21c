//! Numbers that note how they were made.

use std::ops::{BitAnd, BitOr, Not};

use num_traits::Zero;

use super::operation::{Binary, Logic, Op, Place, Unary};
use super::recording::current;
use crate::elementary::Elementary;
use crate::operators::operators;
use crate::real::{Fused, Mask, Real};

/// A number without a value: running generic code over it records an operation for each call. Since
/// such code cannot branch on values, one recording serves all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Symbol(pub(crate) Place);

/// A comparison, or several of them joined.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SymbolMask(Place);

impl Symbol {
    /// An argument of the recorded code.
    pub(crate) fn input(number: usize) -> Self {
        push(Op::Input(number as u32))
    }

    /// An argument that all points of a sum share.
    pub(crate) fn shared(number: usize) -> Self {
        Symbol(Place::shared(number))
    }
}

fn push(op: Op) -> Symbol {
    Symbol(current(|recording| recording.push(op)))
}

fn unary(f: Unary, x: Symbol) -> Symbol {
    push(Op::Unary(f, x.0))
}

fn binary(f: Binary, a: Symbol, b: Symbol) -> Symbol {
    push(Op::Binary(f, [a.0, b.0]))
}

fn logic(f: Logic, a: Place, b: Place) -> SymbolMask {
    SymbolMask(push(Op::Logic(f, [a, b])).0)
}

/// Where a slice begins, if its numbers lie one after the other in a plain recording.
fn run(slice: &[Symbol]) -> Option<Place> {
    let first = slice.first()?.0;
    let mut places = slice.iter().enumerate();
    let is_run = places.all(|(i, x)| x.0 == first.plus(i));
    (is_run && !current(|recording| recording.is_simplified)).then_some(first)
}

operators! {
    impl[] Symbol:
    a + b => binary(Binary::Add, a, b),
    a - b => binary(Binary::Sub, a, b),
    a * b => binary(Binary::Mul, a, b),
    a / b => binary(Binary::Div, a, b),
    -a => unary(Unary::Neg, a),
    0 => Symbol::lit(0.0),
    1 => Symbol::lit(1.0),
    // A question about the value: only a simplified recording, whose code is printed for all values, may
    // answer it by what it knows.
    a == 0 => current(|recording| {
        recording.unfit = true;
        recording.is_simplified && recording.constant(a.0) == Some(0.0)
    }),
}

impl BitAnd for SymbolMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        logic(Logic::And, self.0, other.0)
    }
}
impl BitOr for SymbolMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        logic(Logic::Or, self.0, other.0)
    }
}
impl Not for SymbolMask {
    type Output = Self;
    fn not(self) -> Self {
        logic(Logic::Not, self.0, self.0)
    }
}
impl Mask for SymbolMask {
    fn splat(value: bool) -> Self {
        SymbolMask(push(Op::Always(value)).0)
    }
    /// In a simplified recording true for any mask, and false for [`all`](Mask::all), as if lanes always
    /// disagreed: then both sides of a choice are printed.
    fn any(self) -> bool {
        current(|recording| {
            recording.unfit = true;
            recording.is_simplified
        })
    }
}

/// Methods that record one operation, of one number and of two.
macro_rules! recorded {
    ($($method:ident $op:ident),*; $($method_of_two:ident $op_of_two:ident),*) => {
        $(
            fn $method(self) -> Self {
                unary(Unary::$op, self)
            }
        )*
        $(
            fn $method_of_two(self, other: Self) -> Self {
                binary(Binary::$op_of_two, self, other)
            }
        )*
    };
}

impl Real for Symbol {
    type Mask = SymbolMask;

    recorded! {
        recip Recip, sqrt Sqrt, rsqrt Rsqrt, exp Exp, ln Ln, sin Sin, cos Cos, tan Tan, tanh Tanh,
        abs Abs, detach Detach;
        atan2 Atan2, powf Powf, hypot Hypot, straight_through StraightThrough
    }

    fn lit(value: f64) -> Self {
        push(Op::Constant(value.to_bits()))
    }
    fn primal(self) -> f64 {
        current(|recording| {
            let refused = "a kernel whose derivatives are emitted cannot ask for a primal";
            assert!(!recording.is_simplified, "{refused}");
            recording.unfit = true;
        });
        f64::NAN
    }
    fn lt(self, other: Self) -> SymbolMask {
        logic(Logic::Lt, self.0, other.0)
    }
    fn le(self, other: Self) -> SymbolMask {
        logic(Logic::Le, self.0, other.0)
    }
    fn select(mask: SymbolMask, if_true: Self, if_false: Self) -> Self {
        push(Op::Select(mask.0, [if_true.0, if_false.0]))
    }
    fn fma(self, factor: Self, term: Self) -> Self {
        push(Op::Fma([self.0, factor.0, term.0]))
    }
    fn powi(self, exponent: i32) -> Self {
        unary(Unary::Powi(exponent), self)
    }
    fn elementary(self, function: Elementary) -> Self {
        unary(Unary::Elementary(function), self)
    }
    fn chain(partial: Self, cotangent: Self) -> Self {
        binary(Binary::Chain, partial, cotangent)
    }
    fn dot(a: &[Self], b: &[Self]) -> Self {
        assert_eq!(a.len(), b.len(), "dot: the slices differ in length");
        if let (Some(x), Some(y)) = (run(a), run(b)) {
            return push(Op::Dot([x, y], a.len() as u32));
        }
        let pairs = a.iter().zip(b);
        pairs.fold(Self::zero(), |sum, (&x, &y)| x.fma(y, sum))
    }
    fn sum_of(terms: &[Self]) -> Self {
        if let Some(x) = run(terms) {
            return push(Op::Sum(x, terms.len() as u32));
        }
        terms.iter().fold(Self::zero(), |sum, &x| sum + x)
    }
    /// The derivative of a fused function need not be that of its `eval`.
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        current(|recording| recording.unfit = true);
        function.eval(inputs)
    }
}
