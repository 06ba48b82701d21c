//! Numbers that note how they were made.

use std::ops::{
    Add, AddAssign, BitAnd, BitOr, Div, DivAssign, Mul, MulAssign, Neg, Not, Sub, SubAssign,
};

use num_traits::{One, Zero};

use super::graph::{GRAPH, Node, place};
use super::known::Known;
use crate::elementary::Elementary;
use crate::real::{Mask, Real};

/// A node of the formula, by its place in the list of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Symbol(pub(super) u32);

/// A comparison, or several of them joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SymbolMask(pub(super) u32);

impl Symbol {
    fn constant(self) -> Option<f64> {
        GRAPH.with_borrow(|graph| graph.constant(self.0))
    }
    fn is(self, value: f64) -> bool {
        self.constant() == Some(value)
    }
    fn node(self) -> Node {
        GRAPH.with_borrow(|graph| graph.nodes[self.0 as usize].0)
    }
    fn known(self) -> Known {
        GRAPH.with_borrow(|graph| graph.nodes[self.0 as usize].1)
    }
    fn unary(self, method: &'static str) -> Self {
        Symbol(place(Node::Unary(method, self.0)))
    }
}

impl Add for Symbol {
    type Output = Self;
    /// A sum with zero is folded, unless adding +0 may change a negative zero, as the rules want it to.
    fn add(self, other: Self) -> Self {
        match () {
            () if self.is(0.0) => other,
            () if other.is(0.0) && (!other.known().unsigned || self.known().unsigned) => self,
            () => Symbol(place(Node::Add(self.0, other.0))),
        }
    }
}
impl Sub for Symbol {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        match () {
            () if other.is(0.0) => self,
            () if self.is(0.0) => -other,
            () => Symbol(place(Node::Sub(self.0, other.0))),
        }
    }
}
impl Mul for Symbol {
    type Output = Self;
    /// Only trivial products are folded: other constants may stand for fields of the kernel. A product
    /// with a constant zero is zero, so that no code is printed for what passes no cotangent.
    fn mul(self, other: Self) -> Self {
        let (a, b) = if self.0 <= other.0 {
            (self, other)
        } else {
            (other, self)
        };
        match (a.constant(), b.constant()) {
            (Some(0.0), _) | (_, Some(0.0)) => Symbol::lit(0.0),
            (Some(1.0), _) => b,
            (_, Some(1.0)) => a,
            (Some(-1.0), _) => -b,
            (_, Some(-1.0)) => -a,
            _ => Symbol(place(Node::Mul(a.0, b.0))),
        }
    }
}
impl Div for Symbol {
    type Output = Self;
    /// As a product with the reciprocal, which an adjoint needs anyway.
    #[allow(clippy::suspicious_arithmetic_impl)]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}
impl Neg for Symbol {
    type Output = Self;
    fn neg(self) -> Self {
        match self.constant() {
            Some(value) => Symbol::lit(-value),
            None => Symbol(place(Node::Neg(self.0))),
        }
    }
}
impl AddAssign for Symbol {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl SubAssign for Symbol {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
impl MulAssign for Symbol {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}
impl DivAssign for Symbol {
    fn div_assign(&mut self, other: Self) {
        *self = *self / other;
    }
}
impl Zero for Symbol {
    fn zero() -> Self {
        Symbol::lit(0.0)
    }
    fn is_zero(&self) -> bool {
        self.is(0.0)
    }
}
impl One for Symbol {
    fn one() -> Self {
        Symbol::lit(1.0)
    }
}

impl BitAnd for SymbolMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        SymbolMask(place(Node::Join('&', self.0, other.0)))
    }
}
impl BitOr for SymbolMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        SymbolMask(place(Node::Join('|', self.0, other.0)))
    }
}
impl Not for SymbolMask {
    type Output = Self;
    fn not(self) -> Self {
        SymbolMask(place(Node::Not(self.0)))
    }
}
impl Mask for SymbolMask {
    fn splat(value: bool) -> Self {
        SymbolMask(place(Node::Always(value)))
    }
    /// True for any mask, and false for [`all`](Mask::all), as if lanes always disagreed: then both sides
    /// of a choice are printed.
    fn any(self) -> bool {
        true
    }
}

impl Real for Symbol {
    type Mask = SymbolMask;

    fn lit(value: f64) -> Self {
        Symbol(place(Node::Constant(value.to_bits())))
    }
    fn lt(self, other: Self) -> SymbolMask {
        SymbolMask(place(Node::Compare("lt", self.0, other.0)))
    }
    fn le(self, other: Self) -> SymbolMask {
        SymbolMask(place(Node::Compare("le", self.0, other.0)))
    }
    fn select(mask: SymbolMask, if_true: Self, if_false: Self) -> Self {
        if if_true == if_false {
            return if_true;
        }
        Symbol(place(Node::Select(mask.0, if_true.0, if_false.0)))
    }
    fn fma(self, factor: Self, term: Self) -> Self {
        Symbol(place(Node::Fma(self.0, factor.0, term.0)))
    }
    fn recip(self) -> Self {
        self.unary("recip")
    }
    fn sqrt(self) -> Self {
        self.unary("sqrt")
    }
    fn exp(self) -> Self {
        self.unary("exp")
    }
    fn ln(self) -> Self {
        self.unary("ln")
    }
    fn sin(self) -> Self {
        self.unary("sin")
    }
    fn cos(self) -> Self {
        self.unary("cos")
    }
    fn tanh(self) -> Self {
        self.unary("tanh")
    }
    fn atan2(self, x: Self) -> Self {
        Symbol(place(Node::Binary("atan2", self.0, x.0)))
    }
    fn powi(self, exponent: i32) -> Self {
        Symbol(place(Node::Powi(self.0, exponent)))
    }
    fn powf(self, exponent: Self) -> Self {
        Symbol(place(Node::Binary("powf", self.0, exponent.0)))
    }
    fn elementary(self, function: Elementary) -> Self {
        Symbol(place(Node::Elementary(function, self.0)))
    }
    fn abs(self) -> Self {
        if self.known().least >= 0.0 {
            self
        } else {
            self.unary("abs")
        }
    }
    /// A select between constants, of which nothing needs to be detached.
    fn signum(self) -> Self {
        let (zero, one) = (Self::zero(), Self::one());
        let negative = Symbol::select(self.lt(zero), -one, zero);
        Symbol::select(zero.lt(self), one, negative)
    }
    fn detach(self) -> Self {
        match self.node() {
            Node::Constant(_) | Node::Unary("detach", _) => self,
            // Into the branches: a choice between constants stays one.
            Node::Select(mask, a, b) => {
                Symbol::select(SymbolMask(mask), Symbol(a).detach(), Symbol(b).detach())
            }
            _ => self.unary("detach"),
        }
    }
    fn straight_through(self, soft: Self) -> Self {
        Symbol(place(Node::Binary("straight_through", self.0, soft.0)))
    }
    fn chain(partial: Self, cotangent: Self) -> Self {
        match partial.node() {
            // Into the branches of a select: what passes nothing is then zero.
            Node::Select(mask, a, b) if Symbol(a).constant().or(Symbol(b).constant()).is_some() => {
                let pass = |branch| Symbol::chain(Symbol(branch), cotangent);
                Symbol::select(SymbolMask(mask), pass(a), pass(b))
            }
            _ if cotangent.is(1.0) || partial.known().is_finite() => partial * cotangent,
            _ => Symbol(place(Node::Chain(partial.0, cotangent.0))),
        }
    }
}
