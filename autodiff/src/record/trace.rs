//! What a function does with its numbers, recorded as a list of operations that can be replayed
//! with others.
//!
//! [`Traced`] is a [`Real`] without a value: running generic code over it records an operation for each
//! call. Since such code cannot branch on values, one record serves all of them. What a record
//! cannot hold, a fused function or a decision by [`Mask::any`], makes [`trace`] return `None`.
//! (No relation to the public module of this name, which looks for the origin of a NaN.)

use std::cell::RefCell;
use std::ops::{
    Add, AddAssign, BitAnd, BitOr, Div, DivAssign, Mul, MulAssign, Neg, Not, Sub, SubAssign,
};

use num_traits::{One, Zero};

use crate::elementary::Elementary;
use crate::real::{Fused, Mask, Real};

/// Where an operand lies: among the numbers that all points share, or among each point's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place(u32);

/// The bit that marks shared places.
const SHARED: u32 = 1 << 31;

impl Place {
    fn shared(at: usize) -> Self {
        Place(index(at) | SHARED)
    }
    fn own(at: usize) -> Self {
        Place(index(at))
    }
    #[inline(always)]
    pub(crate) fn is_shared(self) -> bool {
        self.0 & SHARED != 0
    }
    #[inline(always)]
    pub(crate) fn at(self) -> usize {
        (self.0 & !SHARED) as usize
    }
    /// The place `steps` further on.
    #[inline(always)]
    pub(crate) fn plus(self, steps: usize) -> Self {
        Place(self.0 + steps as u32)
    }
}

fn index(at: usize) -> u32 {
    assert!(
        at < SHARED as usize,
        "a summand takes more than {SHARED} operations"
    );
    at as u32
}

/// A function of one number.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Unary {
    Neg,
    Recip,
    Sqrt,
    Rsqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Tanh,
    Abs,
    Powi(i32),
    Elementary(Elementary),
}

/// A function of two numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Atan2,
    Powf,
    Hypot,
    Chain,
}

/// An operation whose result is a mask, stored as a number: 1 for true, 0 for false.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Logic {
    Less,
    LessOrEqual,
    And,
    Or,
    Not,
}

/// One operation; its result takes the next own place.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Op {
    /// `keep` is where its partial is kept for the reverse sweep.
    Unary {
        f: Unary,
        x: Place,
        keep: u32,
    },
    Binary {
        f: Binary,
        x: [Place; 2],
    },
    Logic {
        f: Logic,
        x: [Place; 2],
    },
    /// `x[0] * x[1] + x[2]`.
    Fma {
        x: [Place; 3],
    },
    /// `x[0]` where the mask holds, else `x[1]`.
    Select {
        mask: Place,
        x: [Place; 2],
    },
    /// The value of `x[0]`, the derivative of `x[1]`.
    StraightThrough {
        x: [Place; 2],
    },
    Detach {
        x: Place,
    },
    /// The dot product of `len` places from each of these on.
    Dot {
        x: [Place; 2],
        len: u32,
    },
    /// The sum of `len` places from this on.
    Sum {
        x: Place,
        len: u32,
    },
}

/// A recorded function of shared numbers and a point's own.
#[derive(Debug, Default)]
pub(crate) struct Trace {
    /// Their places are shared ones, after the shared arguments.
    pub(crate) constants: Vec<f64>,
    /// The places of their results are own ones, after the own arguments.
    pub(crate) ops: Vec<Op>,
    pub(crate) result: Place,
    /// How many shared and how many own arguments there are.
    pub(crate) arguments: [usize; 2],
    /// How many partials are kept.
    pub(crate) kept: usize,
    /// Whether something was called that a record cannot hold.
    unfit: bool,
}

thread_local! {
    static RECORDING: RefCell<Trace> = RefCell::default();
}

/// Puts an outer recording back, also when the function panics.
struct Restore(Trace);

impl Drop for Restore {
    fn drop(&mut self) {
        RECORDING.replace(std::mem::take(&mut self.0));
    }
}

/// Records `function(shared, own)`, given how many numbers there are of each; `None` where a
/// record cannot hold it.
pub(crate) fn trace(
    arguments: [usize; 2],
    function: impl FnOnce(&[Traced], &[Traced]) -> Traced,
) -> Option<Trace> {
    let fresh = Trace {
        arguments,
        ..Trace::default()
    };
    let _restore = Restore(RECORDING.replace(fresh));
    let [shared, own] = arguments;
    let shared: Vec<Traced> = (0..shared).map(|i| Traced(Place::shared(i))).collect();
    let own: Vec<Traced> = (0..own).map(|i| Traced(Place::own(i))).collect();
    let result = function(&shared, &own);
    let mut trace = RECORDING.take();
    trace.result = result.0;
    (!trace.unfit).then_some(trace)
}

fn push(op: Op) -> Traced {
    RECORDING.with_borrow_mut(|trace| {
        trace.ops.push(op);
        Traced(Place::own(trace.arguments[1] + trace.ops.len() - 1))
    })
}

fn unary(f: Unary, x: Traced) -> Traced {
    let keep = RECORDING.with_borrow_mut(|trace| {
        trace.kept += 1;
        index(trace.kept - 1)
    });
    push(Op::Unary { f, x: x.0, keep })
}

fn binary(f: Binary, x: [Traced; 2]) -> Traced {
    push(Op::Binary {
        f,
        x: x.map(|x| x.0),
    })
}

fn logic(f: Logic, x: [Place; 2]) -> TracedMask {
    TracedMask(push(Op::Logic { f, x }).0)
}

/// Marks the recording as one that cannot be replayed.
fn unfit() {
    RECORDING.with_borrow_mut(|trace| trace.unfit = true);
}

/// Where a slice begins, if its numbers lie one after the other.
fn run(slice: &[Traced]) -> Option<Place> {
    let first = slice.first()?.0;
    let mut places = slice.iter().enumerate();
    places.all(|(i, x)| x.0 == first.plus(i)).then_some(first)
}

/// A number of which only the place is known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traced(Place);

/// The outcome of a comparison, likewise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TracedMask(Place);

impl BitAnd for TracedMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        logic(Logic::And, [self.0, other.0])
    }
}

impl BitOr for TracedMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        logic(Logic::Or, [self.0, other.0])
    }
}

impl Not for TracedMask {
    type Output = Self;
    fn not(self) -> Self {
        logic(Logic::Not, [self.0, self.0])
    }
}

impl Mask for TracedMask {
    fn splat(value: bool) -> Self {
        TracedMask(Traced::lit(if value { 1.0 } else { 0.0 }).0)
    }
    fn any(self) -> bool {
        unfit();
        false
    }
}

impl Real for Traced {
    type Mask = TracedMask;

    fn lit(value: f64) -> Self {
        RECORDING.with_borrow_mut(|trace| {
            trace.constants.push(value);
            Traced(Place::shared(
                trace.arguments[0] + trace.constants.len() - 1,
            ))
        })
    }
    fn lt(self, other: Self) -> TracedMask {
        logic(Logic::Less, [self.0, other.0])
    }
    fn le(self, other: Self) -> TracedMask {
        logic(Logic::LessOrEqual, [self.0, other.0])
    }
    fn select(mask: TracedMask, if_true: Self, if_false: Self) -> Self {
        push(Op::Select {
            mask: mask.0,
            x: [if_true.0, if_false.0],
        })
    }
    fn fma(self, factor: Self, term: Self) -> Self {
        push(Op::Fma {
            x: [self.0, factor.0, term.0],
        })
    }
    fn recip(self) -> Self {
        unary(Unary::Recip, self)
    }
    fn sqrt(self) -> Self {
        unary(Unary::Sqrt, self)
    }
    fn rsqrt(self) -> Self {
        unary(Unary::Rsqrt, self)
    }
    fn exp(self) -> Self {
        unary(Unary::Exp, self)
    }
    fn ln(self) -> Self {
        unary(Unary::Ln, self)
    }
    fn sin(self) -> Self {
        unary(Unary::Sin, self)
    }
    fn cos(self) -> Self {
        unary(Unary::Cos, self)
    }
    fn tan(self) -> Self {
        unary(Unary::Tan, self)
    }
    fn tanh(self) -> Self {
        unary(Unary::Tanh, self)
    }
    fn atan2(self, x: Self) -> Self {
        binary(Binary::Atan2, [self, x])
    }
    fn powi(self, exponent: i32) -> Self {
        unary(Unary::Powi(exponent), self)
    }
    fn powf(self, exponent: Self) -> Self {
        binary(Binary::Powf, [self, exponent])
    }
    fn elementary(self, function: Elementary) -> Self {
        unary(Unary::Elementary(function), self)
    }
    fn abs(self) -> Self {
        unary(Unary::Abs, self)
    }
    fn hypot(self, other: Self) -> Self {
        binary(Binary::Hypot, [self, other])
    }
    fn detach(self) -> Self {
        push(Op::Detach { x: self.0 })
    }
    fn straight_through(self, soft: Self) -> Self {
        push(Op::StraightThrough {
            x: [self.0, soft.0],
        })
    }
    fn chain(partial: Self, cotangent: Self) -> Self {
        binary(Binary::Chain, [partial, cotangent])
    }
    fn dot(a: &[Self], b: &[Self]) -> Self {
        assert_eq!(a.len(), b.len(), "dot: the slices differ in length");
        if let (Some(x), Some(y)) = (run(a), run(b)) {
            let (x, len) = ([x, y], index(a.len()));
            return push(Op::Dot { x, len });
        }
        let pairs = a.iter().zip(b);
        pairs.fold(Self::zero(), |sum, (&x, &y)| x.fma(y, sum))
    }
    fn sum(terms: &[Self]) -> Self {
        if let Some(x) = run(terms) {
            let len = index(terms.len());
            return push(Op::Sum { x, len });
        }
        terms.iter().fold(Self::zero(), |sum, &x| sum + x)
    }
    /// The derivative of a fused function need not be that of its `eval`.
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        unfit();
        function.eval(inputs)
    }
}

impl Add for Traced {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        binary(Binary::Add, [self, other])
    }
}

impl Sub for Traced {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        binary(Binary::Sub, [self, other])
    }
}

impl Mul for Traced {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        binary(Binary::Mul, [self, other])
    }
}

impl Div for Traced {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        binary(Binary::Div, [self, other])
    }
}

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        unary(Unary::Neg, self)
    }
}

impl AddAssign for Traced {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Traced {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Traced {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl DivAssign for Traced {
    fn div_assign(&mut self, other: Self) {
        *self = *self / other;
    }
}

impl Zero for Traced {
    fn zero() -> Self {
        Self::lit(0.0)
    }
    /// A question about the value, which a record cannot answer.
    fn is_zero(&self) -> bool {
        unfit();
        false
    }
}

impl One for Traced {
    fn one() -> Self {
        Self::lit(1.0)
    }
}
