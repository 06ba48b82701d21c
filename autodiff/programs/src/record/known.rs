//! Derives bounds on a number from the way it is computed.

use super::operation::{Op, Unary};

/// Bounds on a number. They hold wherever the inputs and the results of the kernel are finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    /// The number is at least this large.
    pub(super) least: f64,
    pub(super) range: Range,
    /// Whether the number cannot be a negative zero. This holds for squares, and for sums in which one term cannot be a
    /// negative zero.
    pub(super) unsigned: bool,
}

/// How large a number may be. A sum of finite terms counts as finite, and so does the product of a finite and a bounded
/// number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Range {
    /// Between two constants.
    Bounded,
    /// Finite, but without constant bounds. Inputs and results are of this kind.
    Finite,
    /// The number may be infinite or NaN because a product overflows, even if the results are finite.
    Overflow,
    /// The number may be infinite or NaN for another reason: an exponential, a power, or a function at the edge of its
    /// domain.
    Singular,
}

use Range::{Bounded, Finite, Overflow, Singular};

/// Numbers of at least this size are safely away from zero: even the cube of their reciprocal is finite in f32. No
/// derivative rule contains a higher power of a reciprocal.
const CLEAR: f64 = 1e-12;

impl Known {
    /// The bounds on a positive number that is safely away from zero.
    pub(super) const CLEAR: Self = Self {
        least: CLEAR,
        range: Bounded,
        unsigned: true,
    };

    /// Returns the bounds on a number of unknown sign.
    pub(super) fn within(range: Range) -> Self {
        Self {
            least: f64::NEG_INFINITY,
            range,
            unsigned: false,
        }
    }

    pub(super) fn constant(value: f64) -> Self {
        if !value.is_finite() {
            return Self::within(Singular);
        }
        Self {
            least: value,
            range: Bounded,
            unsigned: value.is_sign_positive(),
        }
    }

    /// Whether the number is known to be finite, so that its product with zero is zero.
    pub(super) fn is_finite(self) -> bool {
        self.range <= Finite
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            least: self.least + other.least,
            range: self.range.max(other.range),
            unsigned: self.unsigned || other.unsigned,
        }
    }

    pub(super) fn times(self, other: Self) -> Self {
        let non_negative = self.least.min(other.least) >= 0.0;
        let wider = self.range.max(other.range);
        Self {
            least: if non_negative {
                self.least * other.least
            } else {
                f64::NEG_INFINITY
            },
            range: match self.range.min(other.range) {
                Bounded => wider,
                _ => wider.max(Overflow),
            },
            unsigned: false,
        }
    }

    pub(super) fn squared(self) -> Self {
        let magnitude = self.through(Unary::Abs);
        Self {
            unsigned: true,
            ..magnitude.times(magnitude)
        }
    }

    /// Returns the bounds on a number that equals one of two numbers, such as the result of a select.
    pub(super) fn or(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            range: self.range.max(other.range),
            unsigned: self.unsigned && other.unsigned,
        }
    }

    /// Returns the bounds on the result of `f` at this number.
    pub(super) fn through(self, f: Unary) -> Self {
        let inside = if self.least >= CLEAR {
            self.range
        } else {
            Singular
        };
        let bounded = |range| if range <= Finite { Bounded } else { range };
        let (least, range) = match f {
            Unary::Rsqrt => return self.through(Unary::Sqrt).through(Unary::Recip),
            Unary::Detach => (self.least, self.range),
            Unary::Neg => (f64::NEG_INFINITY, self.range),
            Unary::Abs => (self.least.max(0.0), self.range),
            Unary::Sqrt => (self.least.max(0.0).sqrt(), inside),
            Unary::Recip if self.least > 0.0 => (0.0, bounded(inside)),
            Unary::Ln => (f64::NEG_INFINITY, inside),
            Unary::Sin | Unary::Cos | Unary::Tanh | Unary::LayerTanh => {
                (f64::NEG_INFINITY, bounded(self.range))
            }
            // The lower bound is 0, because the exponential may underflow.
            Unary::Exp => (0.0, Singular),
            _ => (f64::NEG_INFINITY, Singular),
        };
        Self {
            least,
            range,
            unsigned: match f {
                Unary::Abs | Unary::Exp => true,
                Unary::Detach => self.unsigned,
                _ => least > 0.0,
            },
        }
    }

    /// Tightens the bounds on the result of `op`. Call this only if an overflow in `op` would make a result of the
    /// kernel infinite or NaN. Then there is no overflow wherever the results are finite.
    pub(super) fn shown(self, op: Op) -> Self {
        let range = match (self.range, op) {
            (Overflow, Op::Unary(Unary::Recip | Unary::Tanh | Unary::LayerTanh, _)) => Bounded,
            (Overflow, _) => Finite,
            (range, _) => range,
        };
        Self { range, ..self }
    }
}
