//! Numbers that record how they are computed.

use std::ops::{BitAnd, BitOr, Not};
use std::panic::Location;

use autodiff::internal::{functions, literal_operators, operators};
use autodiff::real::Accepts;
use autodiff::{Elementary, Fused, Mask, Real};
use num_traits::Zero;
use smallvec::SmallVec;

use super::computed;
use super::operation::{Binary, Logic, Op, Place, Run, Unary};
use super::recording::current;

/// A number without a value. Generic code over symbols records one operation for each call. It cannot branch on values,
/// so one recording is valid for all values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Symbol(pub(crate) Place);

/// The result of a comparison, or of a combination of comparisons.
#[derive(Clone, Copy, Debug)]
pub struct SymbolMask(Place);

impl Symbol {
    /// Returns argument number `number` of the recorded code.
    pub(crate) fn input(number: usize) -> Self {
        push(Op::Input(number as u32))
    }

    /// Returns shared argument number `number`, which has the same value at all points.
    pub(crate) fn shared(number: usize) -> Self {
        Symbol(Place::shared(number))
    }
}

#[track_caller]
fn push(op: Op) -> Symbol {
    if let Some(place) = computed::current(|values| values.push(op)) {
        return Symbol(place);
    }
    let line = Some(Location::caller());
    Symbol(current(|recording| {
        recording.line = line;
        recording.push(op)
    }))
}

#[track_caller]
fn unary(f: Unary, x: Symbol) -> Symbol {
    push(Op::Unary(f, x.0))
}

#[track_caller]
fn binary(f: Binary, a: Symbol, b: Symbol) -> Symbol {
    push(Op::Binary(f, [a.0, b.0]))
}

#[track_caller]
fn logic(f: Logic, a: Place, b: Place) -> SymbolMask {
    SymbolMask(push(Op::Logic(f, [a, b])).0)
}

/// Returns the longest run with which a slice begins, and the length of this run.
fn run(slice: &[Symbol]) -> (Run, usize) {
    let first = slice[0].0;
    let step = slice.get(1).and_then(|second| first.distance(second.0));
    let Some(step) = step else {
        return (Run { first, step: 1 }, 1);
    };
    let run = Run { first, step };
    let mut len = 0;
    // Compares whole chunks in registers, because the rows of a network are long.
    for chunk in slice.chunks(CHUNK) {
        let places = chunk.iter().enumerate();
        let in_line = places.map(|(j, x)| x.0 == run.at(len + j));
        let count = in_line.clone().fold(0, |count, is| count + usize::from(is));
        if count < chunk.len() {
            return (run, len + in_line.take_while(|is| *is).count());
        }
        len += count;
    }
    (run, len)
}

/// How many places are compared at once.
const CHUNK: usize = 32;

/// Two runs of equal length, one in each of two slices, and their length.
type Stretch = ([Run; 2], u32);

/// Divides two slices of equal length into stretches. Within a stretch, the places of each slice are at equal
/// distances. Returns `None` in a simplified recording, and if the stretches have fewer than two terms on average.
fn stretches(a: &[Symbol], b: &[Symbol]) -> Option<SmallVec<[Stretch; 2]>> {
    if current(|recording| recording.is_simplified) {
        return None;
    }
    let (mut stretches, mut from) = (SmallVec::new(), 0);
    while from < a.len() {
        let ((x, len_x), (y, len_y)) = (run(&a[from..]), run(&b[from..]));
        let len = len_x.min(len_y);
        stretches.push(([x, y], len as u32));
        from += len;
        if stretches.len() > 1 && 2 * stretches.len() > a.len() {
            return None;
        }
    }
    Some(stretches)
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
    a == 0 => is_zero(a),
}

literal_operators! { [] Symbol }

/// Without values, the recording becomes unfit for a replay. A constant zero counts as zero then, and every other number does
/// not: nalgebra does not initialise memory that it multiplies by `zero()`.
fn is_zero(x: Symbol) -> bool {
    let known = computed::current(|values| values.is_zero(x.0));
    known.unwrap_or_else(|| {
        current(|recording| {
            recording.unfit = true;
            recording.constant(x.0) == Some(0.0)
        })
    })
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
    /// In a simplified recording, `any` is always true and [`all`](Mask::all) is always false, as if the lanes
    /// differed. So the code for both values of the mask is printed.
    fn any(self) -> bool {
        if let Some(any) = computed::current(|values| values.any(self.0)) {
            return any;
        }
        current(|recording| {
            recording.unfit = true;
            recording.is_simplified
        })
    }
}

/// Defines methods that each record one operation.
macro_rules! recorded {
    (basic { $($method:ident $Basic:ident),* } composed { $($_composed:tt)* }) => {
        $(
            #[track_caller]
            fn $method(self) -> Self {
                unary(Unary::$Basic, self)
            }
        )*
    };
    (of_two $($method:ident $Function:ident,)*) => {
        $(
            #[track_caller]
            fn $method<T>(self, other: T) -> Self
            where
                Self: Accepts<T>,
            {
                binary(Binary::$Function, self, Self::accept(other))
            }
        )*
    };
}

impl Real for Symbol {
    type Mask = SymbolMask;

    functions!(recorded);
    recorded! { of_two atan2 Atan2, powf Powf, hypot Hypot, }

    #[track_caller]
    fn straight_through(self, soft: Self) -> Self {
        binary(Binary::StraightThrough, self, soft)
    }

    #[track_caller]
    fn abs(self) -> Self {
        unary(Unary::Abs, self)
    }
    #[track_caller]
    fn detach(self) -> Self {
        unary(Unary::Detach, self)
    }
    #[track_caller]
    fn lit(value: f64) -> Self {
        push(Op::Constant(value.to_bits()))
    }
    #[track_caller]
    fn primal(self) -> f64 {
        if let Some(primal) = computed::current(|values| values.primal(self.0)) {
            return primal;
        }
        let is_emitted = current(|recording| {
            recording.unfit = true;
            recording.is_simplified
        });
        assert!(
            !is_emitted,
            "a kernel with emitted derivatives cannot call `primal`, because its recording has no values"
        );
        f64::NAN
    }
    #[track_caller]
    fn less<T>(self, other: T) -> SymbolMask
    where
        Self: Accepts<T>,
    {
        logic(Logic::Less, self.0, Self::accept(other).0)
    }
    #[track_caller]
    fn less_equal<T>(self, other: T) -> SymbolMask
    where
        Self: Accepts<T>,
    {
        logic(Logic::LessEqual, self.0, Self::accept(other).0)
    }
    #[track_caller]
    fn select(mask: SymbolMask, if_true: Self, if_false: Self) -> Self {
        push(Op::Select(mask.0, [if_true.0, if_false.0]))
    }
    #[track_caller]
    fn fma(self, factor: Self, term: Self) -> Self {
        push(Op::Fma([self.0, factor.0, term.0]))
    }
    #[track_caller]
    fn powi(self, exponent: i32) -> Self {
        unary(Unary::Powi(exponent), self)
    }
    #[track_caller]
    fn elementary(self, function: Elementary) -> Self {
        unary(Unary::Elementary(function), self)
    }
    #[track_caller]
    fn chain(partial: Self, cotangent: Self) -> Self {
        binary(Binary::Chain, partial, cotangent)
    }
    #[track_caller]
    fn dot<T: Copy>(a: &[Self], b: &[T]) -> Self
    where
        Self: Accepts<T>,
    {
        assert_eq!(a.len(), b.len(), "dot: the slices differ in length");
        let b: Vec<Self> = b.iter().map(|&y| Self::accept(y)).collect();
        if let Some(stretches) = stretches(a, &b) {
            let dots = stretches.into_iter().map(|(x, len)| push(Op::Dot(x, len)));
            return dots.reduce(|sum, x| sum + x).unwrap_or_else(Self::zero);
        }
        let pairs = a.iter().zip(&b);
        pairs.fold(Self::zero(), |sum, (&x, &y)| x.fma(y, sum))
    }
    #[track_caller]
    fn sum_of(terms: &[Self]) -> Self {
        if terms.len() > 128 {
            // A replay adds the terms of one operation from first to last.
            let sums: Vec<Self> = terms.chunks(16).map(Self::sum_of).collect();
            return Self::sum_of(&sums);
        }
        if let Some(stretches) = stretches(terms, terms) {
            let sums = stretches
                .into_iter()
                .map(|([x, _], len)| push(Op::Sum(x, len)));
            return sums.reduce(|sum, x| sum + x).unwrap_or_else(Self::zero);
        }
        terms.iter().fold(Self::zero(), |sum, &term| sum + term)
    }
    /// Marks the recording as unfit, because a fused function may have another derivative than its `eval`.
    fn fused<F: Fused>(function: F, inputs: &[&[Self]]) -> Vec<Self> {
        current(|recording| recording.unfit = true);
        function.eval(inputs)
    }
}
