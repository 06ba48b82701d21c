//! Functions that are compiled once and evaluated in any number type.
//!
//! A test that runs many functions in many modes would compile each function for each mode. A [`Formula`] records a
//! function once, over the symbols [`Sym`]. A replay calls the same methods of another number in the same order.
//! `Sym` is also the example of a number type of another crate: it implements `Real` through the public interface.

use std::cell::RefCell;
use std::fmt::Debug;
use std::iter::{Product, Sum};
use std::mem::{replace, take};
use std::ops::{
    Add, AddAssign, BitAnd, BitOr, Div, DivAssign, Mul, MulAssign, Neg, Not, Sub, SubAssign,
};

use autodiff::real::{Accepts, Literal};
use autodiff::{Elementary, Function, Mask, Real, lit};
use num_traits::{One, Zero};

/// A number in a recorded formula: its index in the formula's list of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sym(usize);

/// A comparison in a recorded formula: its index in the formula's list of comparisons.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth(usize);

#[derive(Clone, Debug)]
enum Op {
    Number(Number),
    Truth(Compare),
}

/// An operation whose result is a number.
#[derive(Clone, Debug)]
enum Number {
    Lit(f64),
    One(One1, Sym),
    Elementary(Elementary, Sym),
    Powi(Sym, i32),
    Scale(Sym, f64),
    Two(Two, Sym, Sym),
    Three(Three, [Sym; 3]),
    Literal(Operator, Sym, f64),
    Select(Truth, Sym, Sym),
    Dot(Vec<Sym>, Vec<Sym>),
    SumOf(Vec<Sym>),
}

/// An operation whose result is a comparison.
#[derive(Clone, Copy, Debug)]
enum Compare {
    Less(Sym, Sym),
    LessEqual(Sym, Sym),
    Finite(Sym),
    Splat(bool),
    And(Truth, Truth),
    Or(Truth, Truth),
    Not(Truth),
}

/// Defines the recorded operations that are methods of [`Real`] with one, two or three operands.
macro_rules! methods {
    ($($Methods:ident $count:literal $places:tt: $($method:ident)*;)*) => {
        $(
            #[derive(Clone, Copy, Debug)]
            #[allow(non_camel_case_types)]
            enum $Methods {
                $($method,)*
            }

            impl $Methods {
                fn apply<R: Real>(self, x: [R; $count]) -> R {
                    match self {
                        $(Self::$method => methods!(@call $method x $places),)*
                    }
                }
            }
        )*
    };
    (@call $method:ident $x:ident ($($place:literal)*)) => { R::$method($($x[$place]),*) };
}
methods! {
    One1 1 (0): neg recip sqrt rsqrt exp ln sin cos tan tanh layer_tanh atan abs signum detach;
    Two 2 (0 1): add sub mul div atan2 powf max min hypot straight_through chain;
    Three 3 (0 1 2): fma clamp chain_add;
}

#[derive(Clone, Copy, Debug)]
enum Operator {
    Add,
    Sub,
    Mul,
    Div,
}

thread_local! {
    static RECORD: RefCell<Record> = const { RefCell::new(Record::new(0)) };
}

#[derive(Debug)]
struct Record {
    ops: Vec<Op>,
    numbers: usize,
    truths: usize,
}

impl Record {
    const fn new(numbers: usize) -> Self {
        Self {
            ops: Vec::new(),
            numbers,
            truths: 0,
        }
    }
}

fn number(op: Number) -> Sym {
    RECORD.with_borrow_mut(|record| {
        record.ops.push(Op::Number(op));
        record.numbers += 1;
        Sym(record.numbers - 1)
    })
}

fn truth(op: Compare) -> Truth {
    RECORD.with_borrow_mut(|record| {
        record.ops.push(Op::Truth(op));
        record.truths += 1;
        Truth(record.truths - 1)
    })
}

/// A recorded function of several numbers.
#[derive(Clone, Debug)]
pub(crate) struct Formula {
    arguments: usize,
    ops: Vec<Op>,
    results: Vec<Sym>,
}

/// Records a function with one result.
pub(crate) fn formula(arguments: usize, function: impl FnOnce(&[Sym]) -> Sym) -> Formula {
    formulas(arguments, |x| vec![function(x)])
}

/// Records a function with several results.
pub(crate) fn formulas(arguments: usize, function: impl FnOnce(&[Sym]) -> Vec<Sym>) -> Formula {
    recorded(arguments, Box::new(function))
}

/// A boxed function, so that recording is compiled once.
type Boxed<'f> = Box<dyn FnOnce(&[Sym]) -> Vec<Sym> + 'f>;

fn recorded(arguments: usize, function: Boxed) -> Formula {
    let outer = RECORD.replace(Record::new(arguments));
    let results = function(&(0..arguments).map(Sym).collect::<Vec<_>>());
    let ops = RECORD.with_borrow_mut(|record| take(&mut replace(record, outer).ops));
    Formula {
        arguments,
        ops,
        results,
    }
}

impl Formula {
    /// Returns all results at `x`.
    pub(crate) fn values<R: Real>(&self, x: &[R]) -> Vec<R> {
        assert_eq!(
            x.len(),
            self.arguments,
            "the number of arguments of a formula"
        );
        let (mut n, mut t) = (x.to_vec(), Vec::new());
        for op in &self.ops {
            match op {
                Op::Number(op) => n.push(op.apply(&n, &t)),
                Op::Truth(op) => t.push(op.apply(&n, &t)),
            }
        }
        self.results.iter().map(|x| n[x.0]).collect()
    }
}

impl Number {
    fn apply<R: Real>(&self, n: &[R], t: &[R::Mask]) -> R {
        let of = |places: &[Sym]| places.iter().map(|x| n[x.0]).collect::<Vec<R>>();
        match *self {
            Self::Lit(value) => R::lit(value),
            Self::One(method, x) => method.apply([n[x.0]]),
            Self::Elementary(function, x) => n[x.0].elementary(function),
            Self::Powi(x, exponent) => n[x.0].powi(exponent),
            Self::Scale(x, factor) => n[x.0].scale(factor),
            Self::Two(method, x, y) => method.apply([n[x.0], n[y.0]]),
            Self::Three(method, x) => method.apply(x.map(|x| n[x.0])),
            Self::Literal(operator, x, y) => operator.apply(n[x.0], y),
            Self::Select(mask, x, y) => R::select(t[mask.0], n[x.0], n[y.0]),
            Self::Dot(ref x, ref y) => R::dot(&of(x), &of(y)),
            Self::SumOf(ref x) => R::sum_of(&of(x)),
        }
    }
}

impl Operator {
    fn apply<R: Real>(self, x: R, y: f64) -> R {
        match self {
            Self::Add => x + lit(y),
            Self::Sub => x - lit(y),
            Self::Mul => x * lit(y),
            Self::Div => x / lit(y),
        }
    }
}

impl Compare {
    fn apply<R: Real>(self, n: &[R], t: &[R::Mask]) -> R::Mask {
        match self {
            Self::Less(x, y) => n[x.0].less(n[y.0]),
            Self::LessEqual(x, y) => n[x.0].less_equal(n[y.0]),
            Self::Finite(x) => n[x.0].finite(),
            Self::Splat(value) => R::Mask::splat(value),
            Self::And(a, b) => t[a.0] & t[b.0],
            Self::Or(a, b) => t[a.0] | t[b.0],
            Self::Not(a) => !t[a.0],
        }
    }
}

impl Function for Formula {
    fn eval<R: Real>(&self, x: &[R]) -> R {
        self.values(x)[0]
    }
}

impl Mask for Truth {
    fn splat(value: bool) -> Self {
        truth(Compare::Splat(value))
    }
    fn any(self) -> bool {
        panic!("a formula has no values")
    }
}

impl BitAnd for Truth {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        truth(Compare::And(self, other))
    }
}

impl BitOr for Truth {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        truth(Compare::Or(self, other))
    }
}

impl Not for Truth {
    type Output = Self;
    fn not(self) -> Self {
        truth(Compare::Not(self))
    }
}

/// The value of a literal.
fn float(literal: Literal) -> f64 {
    literal * 1.0
}

macro_rules! operators {
    ($($Trait:ident $method:ident $Assign:ident $assign:ident,)*) => {
        $(
            impl $Trait for Sym {
                type Output = Self;
                fn $method(self, other: Self) -> Self {
                    number(Number::Two(Two::$method, self, other))
                }
            }
            impl $Assign for Sym {
                fn $assign(&mut self, other: Self) {
                    *self = self.$method(other);
                }
            }
            impl $Trait<Literal> for Sym {
                type Output = Self;
                fn $method(self, literal: Literal) -> Self {
                    number(Number::Literal(Operator::$Trait, self, float(literal)))
                }
            }
            impl $Assign<Literal> for Sym {
                fn $assign(&mut self, literal: Literal) {
                    *self = self.$method(literal);
                }
            }
        )*
    };
}
operators! {
    Add add AddAssign add_assign,
    Sub sub SubAssign sub_assign,
    Mul mul MulAssign mul_assign,
    Div div DivAssign div_assign,
}

impl Accepts<f64> for Sym {
    fn accept(argument: f64) -> Self {
        Self::lit(argument)
    }
}

impl Neg for Sym {
    type Output = Self;
    fn neg(self) -> Self {
        number(Number::One(One1::neg, self))
    }
}

impl Zero for Sym {
    fn zero() -> Self {
        Self::lit(0.0)
    }
    fn is_zero(&self) -> bool {
        false
    }
}

impl One for Sym {
    fn one() -> Self {
        Self::lit(1.0)
    }
}

impl Sum for Sym {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::zero(), Self::add)
    }
}

impl Product for Sym {
    fn product<I: Iterator<Item = Self>>(factors: I) -> Self {
        factors.fold(Self::one(), Self::mul)
    }
}

impl<'a> Sum<&'a Self> for Sym {
    fn sum<I: Iterator<Item = &'a Self>>(terms: I) -> Self {
        terms.copied().sum()
    }
}

impl<'a> Product<&'a Self> for Sym {
    fn product<I: Iterator<Item = &'a Self>>(factors: I) -> Self {
        factors.copied().product()
    }
}

/// Implements methods of `Sym` that record the operation of the same name.
macro_rules! recorded {
    ($($kind:ident $Kind:ident ($($x:ident)*): $($method:ident)*;)*) => {
        $(recorded!(@each $kind $Kind ($($x)*) $($method)*);)*
    };
    (@each One $Kind:ident () $($method:ident)*) => {
        $(fn $method(self) -> Self {
            number(Number::One($Kind::$method, self))
        })*
    };
    (@each Two $Kind:ident (y) $($method:ident)*) => {
        $(fn $method<T>(self, y: T) -> Self
        where
            Self: Accepts<T>,
        {
            number(Number::Two($Kind::$method, self, Self::accept(y)))
        })*
    };
}

impl Real for Sym {
    type Mask = Truth;

    recorded! {
        One One1 (): recip sqrt rsqrt exp ln sin cos tan tanh layer_tanh atan abs signum detach;
        Two Two (y): atan2 powf max min hypot;
    }

    fn straight_through(self, soft: Self) -> Self {
        number(Number::Two(Two::straight_through, self, soft))
    }
    fn fma(self, factor: Self, term: Self) -> Self {
        number(Number::Three(Three::fma, [self, factor, term]))
    }
    fn clamp<L, H>(self, lo: L, hi: H) -> Self
    where
        Self: Accepts<L> + Accepts<H>,
    {
        let bounds = (Self::accept(lo), Self::accept(hi));
        number(Number::Three(Three::clamp, [self, bounds.0, bounds.1]))
    }

    fn lit(value: f64) -> Self {
        number(Number::Lit(value))
    }
    fn primal(self) -> f64 {
        panic!("a formula has no values")
    }
    fn less<T>(self, other: T) -> Truth
    where
        Self: Accepts<T>,
    {
        truth(Compare::Less(self, Self::accept(other)))
    }
    fn less_equal<T>(self, other: T) -> Truth
    where
        Self: Accepts<T>,
    {
        truth(Compare::LessEqual(self, Self::accept(other)))
    }
    fn finite(self) -> Truth {
        truth(Compare::Finite(self))
    }
    fn select(mask: Truth, if_true: Self, if_false: Self) -> Self {
        number(Number::Select(mask, if_true, if_false))
    }
    fn scale(self, factor: f64) -> Self {
        number(Number::Scale(self, factor))
    }
    fn powi(self, exponent: i32) -> Self {
        number(Number::Powi(self, exponent))
    }
    fn elementary(self, function: Elementary) -> Self {
        number(Number::Elementary(function, self))
    }
    fn chain(partial: Self, cotangent: Self) -> Self {
        number(Number::Two(Two::chain, partial, cotangent))
    }
    fn chain_add(partial: Self, cotangent: Self, term: Self) -> Self {
        number(Number::Three(Three::chain_add, [partial, cotangent, term]))
    }
    fn dot<T: Copy>(a: &[Self], b: &[T]) -> Self
    where
        Self: Accepts<T>,
    {
        let b = b.iter().map(|&y| Self::accept(y)).collect();
        number(Number::Dot(a.to_vec(), b))
    }
    fn sum_of(terms: &[Self]) -> Self {
        number(Number::SumOf(terms.to_vec()))
    }
}
