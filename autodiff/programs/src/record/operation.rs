//! The operations of a recording.

use autodiff::Elementary;
use autodiff::internal::functions;

/// Identifies a number of a recording. It is the index either of a shared argument, which is the same at all points, or
/// of the operation whose result it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place(u32);

/// This bit is set in the places of shared arguments.
const SHARED: u32 = 1 << 31;

impl Place {
    pub(crate) fn shared(at: usize) -> Self {
        Place(Self::own(at).0 | SHARED)
    }
    pub(crate) fn own(at: usize) -> Self {
        assert!(
            at < SHARED as usize,
            "the recording is full: it can hold at most {SHARED} numbers"
        );
        Place(at as u32)
    }
    #[inline(always)]
    pub(crate) fn is_shared(self) -> bool {
        self.0 & SHARED != 0
    }
    /// The place's index among the shared arguments if it is a shared argument, otherwise among the operations.
    #[inline(always)]
    pub fn at(self) -> usize {
        (self.0 & !SHARED) as usize
    }
    /// The distance to the place `later`. `None` unless `later` is larger and both places are shared arguments or both
    /// are operations.
    pub(super) fn distance(self, later: Self) -> Option<u32> {
        (self.is_shared() == later.is_shared() && self < later).then(|| later.0 - self.0)
    }
    /// The place whose index is larger than this place's by `steps`.
    #[inline(always)]
    pub(crate) fn plus(self, steps: usize) -> Self {
        Place(self.0 + steps as u32)
    }
}

/// A sequence of places (indices in a recording) at equal distances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Run {
    pub first: Place,
    pub step: u32,
}

impl Run {
    #[inline(always)]
    pub(crate) fn at(self, index: usize) -> Place {
        self.first.plus(index * self.step as usize)
    }

    #[inline(always)]
    pub(crate) fn is_adjacent(self) -> bool {
        self.step == 1
    }

    /// Whether the run is a row: adjacent shared arguments.
    #[inline(always)]
    pub(crate) fn is_row(self) -> bool {
        self.first.is_shared() && self.is_adjacent()
    }

    /// The rest of the run from its place number `index` on.
    #[inline(always)]
    pub(crate) fn from(self, index: usize) -> Self {
        Self {
            first: self.at(index),
            ..self
        }
    }
}

macro_rules! define {
    (basic { $($method:ident $Basic:ident),* } composed { $($_composed:tt)* }) => {
        /// A function of one number.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Unary {
            Neg,
            Abs,
            Detach,
            Powi(i32),
            Elementary(Elementary),
            $($Basic,)*
        }

        impl Unary {
            /// The name of the method of [`Real`](autodiff::Real) that computes the function.
            pub(super) fn method(self) -> &'static str {
                match self {
                    Self::Neg => "neg",
                    Self::Abs => "abs",
                    Self::Detach => "detach",
                    Self::Powi(_) => "powi",
                    Self::Elementary(function) => function.name(),
                    $(Self::$Basic => stringify!($method),)*
                }
            }
        }
    };
}

functions!(define);

/// A function of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Atan2,
    Powf,
    Hypot,
    Chain,
    /// A number with the value of the first operand and the derivative of the second.
    StraightThrough,
}

/// An operation whose result is a mask.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Logic {
    Less,
    LessEqual,
    And,
    Or,
    /// The negation of the first operand; the second is ignored.
    Not,
}

/// One operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    /// The input with this number.
    Input(u32),
    /// A constant, as the bits of an f64.
    Constant(u64),
    /// A mask with the same value in every lane.
    Always(bool),
    Unary(Unary, Place),
    Binary(Binary, [Place; 2]),
    Logic(Logic, [Place; 2]),
    /// The product of the first two operands, plus the third.
    Fma([Place; 3]),
    /// The first number where the mask is true, otherwise the second.
    Select(Place, [Place; 2]),
    /// The dot product of two runs of this length.
    Dot([Run; 2], u32),
    /// The sum over a run of this length.
    Sum(Run, u32),
}

impl Op {
    /// Returns the operation with each run of operands replaced by the result of `f`. Arguments of `f` are the run and
    /// its length; a single operand is a run of length 1.
    pub(crate) fn with_operands(self, mut f: impl FnMut(Run, u32) -> Run) -> Self {
        let mut one = |place| {
            f(
                Run {
                    first: place,
                    step: 1,
                },
                1,
            )
            .first
        };
        match self {
            Op::Input(_) | Op::Constant(_) | Op::Always(_) => self,
            Op::Unary(name, x) => Op::Unary(name, one(x)),
            Op::Binary(name, x) => Op::Binary(name, x.map(one)),
            Op::Logic(name, x) => Op::Logic(name, x.map(one)),
            Op::Fma(x) => Op::Fma(x.map(one)),
            Op::Select(mask, x) => Op::Select(one(mask), x.map(one)),
            Op::Dot(x, len) => Op::Dot(x.map(|x| f(x, len)), len),
            Op::Sum(x, len) => Op::Sum(f(x, len), len),
        }
    }

    /// Returns all places that the operation reads.
    pub fn operands(self) -> Vec<Place> {
        let mut operands = Vec::new();
        self.with_operands(|run, len| {
            operands.extend((0..len as usize).map(|j| run.at(j)));
            run
        });
        operands
    }

    /// Returns the operands that must be finite if the result is finite.
    pub(super) fn shows(self) -> Vec<Place> {
        use Unary::{Abs, Cos, Detach, Ln, Neg, Sin, Sqrt};
        match self {
            Op::Fma(_)
            | Op::Binary(Binary::Add | Binary::Sub | Binary::Mul, _)
            | Op::Unary(Abs | Cos | Detach | Ln | Neg | Sin | Sqrt, _) => self.operands(),
            Op::Binary(Binary::StraightThrough, [hard, _]) => vec![hard],
            _ => vec![],
        }
    }
}
