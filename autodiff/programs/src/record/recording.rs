//! The list of operations that generic code does.

use std::cell::RefCell;
use std::collections::HashMap;

use autodiff::internal::{Line, Restored};

use super::known::{Known, Range};
use super::operation::{Binary, Op, Place, Unary};

/// The operations of generic code. A place is the index of the operation that computes the number.
///
/// A plain recording is for replays and has the operations in the order of the code. A simplified recording is for
/// [`emit`](crate::emit). It has each subexpression once and no trivial operations.
#[derive(Debug, Default)]
pub(crate) struct Recording {
    pub(crate) ops: Vec<Op>,
    /// The line of each operation.
    pub(super) lines: Vec<Line>,
    /// The line of the operation that is recorded now.
    pub(super) line: Line,
    /// Whether the recording is unfit for a replay: the code has asked for a value, or has called a function with its
    /// own derivative. The recorded operations then do not represent the code.
    pub(crate) unfit: bool,
    pub(super) is_simplified: bool,
    /// Whether every call is recorded as a separate operation, without simplification. Two recordings of the
    /// same code then have the same operations at the same places.
    is_verbatim: bool,
    /// The magnitudes of the constants that stand for fields of a kernel, and whether the field is promised to be
    /// positive. About the other constants only one thing is known: they are finite.
    fields: Vec<(f64, bool)>,
    /// Bounds on the result of each operation. Only in a simplified recording.
    known: Vec<Known>,
    /// The places of recorded operations that must not be recorded twice (hash-consing): constants and, in a simplified
    /// recording, all operations.
    places: HashMap<Op, Place>,
}

/// The largest number of operations of a kernel that can be emitted.
const MOST: usize = 1 << 20;

thread_local! {
    static CURRENT: RefCell<Recording> = RefCell::default();
}

/// Runs `code` and records its operations in `recording`. Returns the result of `code` and the recording.
pub(crate) fn record<T>(recording: Recording, code: impl FnOnce() -> T) -> (T, Recording) {
    let _outer = Restored::set(&CURRENT, recording);
    let result = code();
    (result, CURRENT.take())
}

/// Calls `work` with the current recording.
pub(crate) fn current<T>(work: impl FnOnce(&mut Recording) -> T) -> T {
    CURRENT.with_borrow_mut(work)
}

impl Recording {
    pub(crate) fn simplified(fields: &[f64], is_positive: &[bool]) -> Self {
        let fields = fields.iter().map(|field| field.abs());
        Self {
            is_simplified: true,
            fields: fields.zip(is_positive.iter().copied()).collect(),
            ..Self::default()
        }
    }

    /// An empty recording that gets one operation for each call. It is used to compare kernels before emission.
    pub(super) fn verbatim() -> Self {
        Self {
            is_verbatim: true,
            ..Self::simplified(&[], &[])
        }
    }

    /// Records an operation and returns the place (the index) of its result.
    pub(super) fn push(&mut self, op: Op) -> Place {
        if self.is_verbatim {
            self.expect_room();
            self.append(op)
        } else if self.is_simplified {
            self.push_simplified(op)
        } else if let Op::Constant(_) = op {
            self.push_once(op)
        } else {
            let op = self.without_zero_slopes(op);
            self.append(op)
        }
    }

    /// Detaches a number that is multiplied by a constant zero, so that it gets no cotangent. A replay would compute this
    /// cotangent as a product with zero, which is NaN if the cotangent of the result is infinite.
    fn without_zero_slopes(&mut self, op: Op) -> Op {
        let is_zero = |place: Place| !place.is_shared() && self.constant(place) == Some(0.0);
        let (Op::Binary(Binary::Mul, [a, b]) | Op::Fma([a, b, _])) = op else {
            return op;
        };
        let [a, b] = match [is_zero(a), is_zero(b)] {
            [true, false] => [a, self.append(Op::Unary(Unary::Detach, b))],
            [false, true] => [self.append(Op::Unary(Unary::Detach, a)), b],
            _ => return op,
        };
        match op {
            Op::Fma([.., term]) => Op::Fma([a, b, term]),
            _ => Op::Binary(Binary::Mul, [a, b]),
        }
    }

    fn append(&mut self, op: Op) -> Place {
        self.ops.push(op);
        self.lines.push(self.line);
        Place::own(self.ops.len() - 1)
    }

    fn push_once(&mut self, op: Op) -> Place {
        if let Some(&place) = self.places.get(&op) {
            return place;
        }
        if self.is_simplified {
            self.expect_room();
            self.known.push(self.knowledge(op));
        }
        let place = self.append(op);
        self.places.insert(op, place);
        place
    }

    /// # Panics
    /// If there are more operations than a source file could reasonably hold.
    fn expect_room(&self) {
        assert!(
            self.ops.len() < MOST,
            "a kernel of more than {MOST} operations cannot be emitted; if it loops until \
             `Mask::any` is false, rewrite the loop, because that never happens while recording"
        );
    }

    fn push_constant(&mut self, value: f64) -> Place {
        self.push(Op::Constant(value.to_bits()))
    }

    /// Records the simplest form of an operation and returns its place. Only trivial sums and products are evaluated,
    /// because other constants may represent fields of the kernel.
    fn push_simplified(&mut self, op: Op) -> Place {
        let is = |place, value| self.constant(place) == Some(value);
        match op {
            Op::Unary(Unary::Neg, x) => match self.constant(x) {
                Some(value) => self.push_constant(-value),
                None => self.push_once(op),
            },
            Op::Unary(Unary::Abs, x) if self.known(x).least >= 0.0 => x,
            Op::Unary(Unary::Detach, x) => self.detached(x),
            Op::Binary(Binary::Add, [a, b]) if is(a, 0.0) => b,
            // Adding +0 can only be dropped if `a` is not a negative zero, because the derivative rules rely on its
            // sign.
            Op::Binary(Binary::Add, [a, b])
                if is(b, 0.0) && (!self.known(b).unsigned || self.known(a).unsigned) =>
            {
                a
            }
            Op::Binary(Binary::Sub, [a, b]) if is(b, 0.0) => a,
            Op::Binary(Binary::Sub, [a, b]) if is(a, 0.0) => self.push(Op::Unary(Unary::Neg, b)),
            Op::Binary(Binary::Mul, [a, b]) => self.product(a.min(b), a.max(b)),
            // A quotient becomes a product with the reciprocal, which the adjoint needs anyway.
            Op::Binary(Binary::Div, [a, b]) => {
                let inverse = self.push(Op::Unary(Unary::Recip, b));
                self.push(Op::Binary(Binary::Mul, [a, inverse]))
            }
            Op::Binary(Binary::Chain, [partial, cotangent]) => self.chained(partial, cotangent),
            Op::Select(_, [a, b]) if a == b => a,
            _ => self.push_once(op),
        }
    }

    /// Records a product. A product with a constant zero becomes zero, so that no code is printed for cotangents that
    /// are always zero.
    fn product(&mut self, a: Place, b: Place) -> Place {
        match (self.constant(a), self.constant(b)) {
            (Some(0.0), _) | (_, Some(0.0)) => self.push_constant(0.0),
            (Some(1.0), _) => b,
            (_, Some(1.0)) => a,
            (Some(-1.0), _) => self.push(Op::Unary(Unary::Neg, b)),
            (_, Some(-1.0)) => self.push(Op::Unary(Unary::Neg, a)),
            _ => self.push_once(Op::Binary(Binary::Mul, [a, b])),
        }
    }

    fn detached(&mut self, x: Place) -> Place {
        match self.op(x) {
            Op::Constant(_) | Op::Unary(Unary::Detach, _) => x,
            // Detaches the two branches instead of the result, so that a select between constants remains a select
            // between constants.
            Op::Select(mask, branches) => {
                let branches = branches.map(|branch| self.detached(branch));
                self.push(Op::Select(mask, branches))
            }
            _ => self.push_once(Op::Unary(Unary::Detach, x)),
        }
    }

    fn chained(&mut self, partial: Place, cotangent: Place) -> Place {
        match self.op(partial) {
            // Applies the chain rule to each branch of the select instead of its result, so that a branch with a zero
            // partial becomes zero.
            Op::Select(mask, branches) if branches.iter().any(|&b| self.constant(b).is_some()) => {
                let branches = branches.map(|branch| self.chained(branch, cotangent));
                self.push(Op::Select(mask, branches))
            }
            _ if self.constant(cotangent) == Some(1.0) || self.known(partial).is_finite() => {
                self.push(Op::Binary(Binary::Mul, [partial, cotangent]))
            }
            _ => self.push_once(Op::Binary(Binary::Chain, [partial, cotangent])),
        }
    }

    /// The operation at a place. A shared argument counts as an input.
    pub(crate) fn op(&self, place: Place) -> Op {
        match place.is_shared() {
            true => Op::Input(place.at() as u32),
            false => self.ops[place.at()],
        }
    }

    pub(super) fn constant(&self, place: Place) -> Option<f64> {
        match self.op(place) {
            Op::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    fn known(&self, place: Place) -> Known {
        match place.is_shared() {
            true => self.knowledge(self.op(place)),
            false => self.known[place.at()],
        }
    }

    /// Returns bounds on the result of an operation that follow from the bounds on its operands.
    fn knowledge(&self, op: Op) -> Known {
        let of = |place| self.known(place);
        let product = |a, b| {
            if a == b {
                of(a).squared()
            } else {
                of(a).times(of(b))
            }
        };
        match op {
            Op::Input(_) => Known::within(Range::Finite),
            Op::Constant(bits) => {
                let value = f64::from_bits(bits);
                let field = self.fields.iter().find(|(field, _)| *field == value.abs());
                match field {
                    None => Known::constant(value),
                    Some((_, true)) if value > 0.0 => Known::CLEAR,
                    Some(_) => Known::within(Range::Bounded),
                }
            }
            Op::Unary(f, x) => of(x).through(f),
            Op::Binary(Binary::Add, [a, b]) => of(a).plus(of(b)),
            Op::Binary(Binary::Sub, [a, b]) => of(a).plus(Known::within(of(b).range)),
            Op::Binary(Binary::Mul | Binary::Chain, [a, b]) => product(a, b),
            Op::Binary(Binary::StraightThrough, [hard, soft]) => Known {
                least: of(hard).least,
                ..of(hard).or(of(soft))
            },
            // The product is not rounded before the addition, so a small negative product may give a negative zero.
            Op::Fma([a, b, c]) => Known {
                unsigned: a == b && of(c).unsigned && of(c).least >= 0.0,
                ..product(a, b).plus(of(c))
            },
            Op::Select(_, [a, b]) => of(a).or(of(b)),
            Op::Logic(..) | Op::Always(_) => Known::within(Range::Bounded),
            Op::Binary(..) | Op::Dot(..) | Op::Sum(..) => Known::within(Range::Singular),
        }
    }

    /// Assumes that these results are finite. Each number whose overflow would make one of these results infinite must
    /// then be finite too. This tightens the bounds on such numbers.
    pub(crate) fn assume_finite(&mut self, results: &[Place]) {
        let mut shown = vec![false; self.ops.len()];
        let mut pending = results.to_vec();
        while let Some(place) = pending.pop() {
            if !std::mem::replace(&mut shown[place.at()], true) {
                pending.extend(self.op(place).shows());
            }
        }
        for (place, shown) in shown.into_iter().enumerate() {
            let op = self.ops[place];
            let known = self.knowledge(op);
            self.known[place] = if shown { known.shown(op) } else { known };
        }
    }
}
