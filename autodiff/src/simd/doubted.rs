//! The hyperbolic tangent in lanes that have no fused multiply-add: nearly always its bits, and word where
//! they may be others.
//!
//! In software a fused multiply-add is some sixty instructions, and a hyperbolic tangent has seventeen of
//! them. Here one is twenty instructions on all lanes: the product and the sum with what rounding took from
//! them (Dekker 1971), and the sum of all that rounded twice, for a remainder that is a little larger and for
//! one that is a little smaller (Ziv 1991). Where both are the same number, it is the fused one. Elsewhere,
//! once in some ten thousand times, software does all of it again. In WebAssembly that makes 21 ns in place
//! of 190.

use std::ops::{Add, Div, Mul, Sub};

use crate::math::{Primitive, tanh_abreast};
use crate::real::{Mask, Real};

/// Lanes without a fused multiply-add.
pub(super) trait Unfused: Real + Primitive {
    /// `self * b + c` rounded once, and where it may be another number. To be relied on, the product may not
    /// be larger than `c`, unless `c` is zero or the sum of both exact; nothing overflows.
    fn fused(self, b: Self, c: Self) -> (Self, Self::Mask);
}

/// The hyperbolic tangents of several registers, with the bits of fused multiply-adds, or `None` if one may
/// have others. Loops, here and below, not closures: some of these are not inlined.
#[inline(always)]
pub(super) fn tanh_unfused<L: Unfused, const N: usize>(mut x: [L; N]) -> Option<[L; N]> {
    let mut lanes = [Doubted::none(L::zero()); N];
    for n in 0..N {
        lanes[n] = Doubted::none(x[n]);
    }
    let found = tanh_abreast(lanes);
    let mut doubt = L::Mask::splat(false);
    for n in 0..N {
        x[n] = found[n].value;
        doubt = doubt | found[n].doubt;
    }
    if doubt.any() { None } else { Some(x) }
}

/// Lanes, and a mask of those that fused multiply-adds may have given other bits.
#[derive(Clone, Copy)]
struct Doubted<L: Real> {
    value: L,
    doubt: L::Mask,
}

/// The remainder is made larger and smaller by this share of it. That is more than its error, and a sum that
/// lies so near the middle between two numbers is rare.
const MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// A number as a sum of two with half the digits each (Veltkamp 1968).
#[inline(always)]
fn halves<L: Real>(a: L) -> [L; 2] {
    let scaled = a * L::lit((1 << 27) as f64 + 1.0);
    let high = scaled - (scaled - a);
    [high, a - high]
}

/// `a * b + c` in double precision, rounded once, for a remainder that is a little larger and one that is a little
/// smaller; `upper` is `a` without the lower 27 of its 53 digits.
#[inline(always)]
pub(super) fn around<L: Real>(a: L, upper: L, b: L, c: L) -> [L; 2] {
    // Several products share their `b`, and so its halves. Those of `a` are fewer instructions.
    let [high, low] = halves(b);
    let product = a * b;
    // At most 2^-53 of the product, with an error below 2^-75 of it; exact where `a` is short.
    let lost = (upper * high - product + upper * low) + (a - upper) * b;
    let sum = c + product;
    let rest = (product - (sum - c)) + lost;
    let (above, below) = (rest * L::lit(1.0 + MARGIN), rest * L::lit(1.0 - MARGIN));
    [sum + above, sum + below]
}

impl<L: Unfused> Doubted<L> {
    #[inline(always)]
    fn none(value: L) -> Self {
        let doubt = L::Mask::splat(false);
        Self { value, doubt }
    }

    /// A value that came of this and of those.
    #[inline(always)]
    fn to<const N: usize>(mut self, value: L, others: [Self; N]) -> Self {
        self.value = value;
        for n in 0..N {
            self.doubt = self.doubt | others[n].doubt;
        }
        self
    }
}

/// Operators of one rounding each.
macro_rules! operator {
    ($($operator:ident $method:ident),*) => {$(
        impl<L: Unfused> $operator for Doubted<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.to(self.value.$method(other.value), [other])
            }
        }
    )*};
}

operator!(Add add, Sub sub, Mul mul, Div div);

impl<L: Unfused> Primitive for Doubted<L> {
    type Scalar = L::Scalar;

    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::none(L::lit(value))
    }
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        let (value, doubt) = self.value.fused(a.value, b.value);
        self.to(value, [a, b, Self { value, doubt }])
    }
    #[inline(always)]
    fn exp2_integer(self) -> Self {
        self.to(self.value.exp2_integer(), [])
    }
    #[inline(always)]
    fn where_less(self, bound: Self, if_less: Self, otherwise: Self) -> Self {
        let value = (self.value).where_less(bound.value, if_less.value, otherwise.value);
        self.to(value, [bound, if_less, otherwise])
    }
    #[inline(always)]
    fn magnitude(self) -> Self {
        self.to(self.value.magnitude(), [])
    }
    #[inline(always)]
    fn with_sign_of(self, other: Self) -> Self {
        self.to(self.value.with_sign_of(other.value), [other])
    }
}

#[cfg(test)]
mod tests {
    use super::{Unfused, around, tanh_unfused};
    use crate::Real;

    impl Unfused for f64 {
        fn fused(self, b: Self, c: Self) -> (Self, bool) {
            let upper = Self::from_bits(self.to_bits() & (u64::MAX << 27));
            let [above, below] = around(self, upper, b, c);
            (above, above != below)
        }
    }

    /// Of 200 000 arguments of all sizes, 400 at the most are in doubt, and the others have the bits of fused
    /// multiply-adds.
    #[test]
    fn it_is_the_fused_one_or_in_doubt() {
        let mut doubts = 0;
        for k in 0..100_000 {
            let t = f64::from(k) / 100_000.0;
            // Beyond 20 it is 1; short numbers, whose sums are ties more often; the smallest there are.
            let spread = 24.0 * (2.0 * t - 1.0) + 0.37e-3;
            let other = match k % 3 {
                0 => f64::from(k % 640) / 32.0,
                1 => -(1e-17_f64.powf(t)),
                _ => 1e-323_f64.powf(t),
            };
            for x in [spread, other] {
                match tanh_unfused([x]) {
                    Some([y]) => assert_eq!(y.to_bits(), Real::tanh(x).to_bits(), "tanh({x:e})"),
                    None => doubts += 1,
                }
            }
        }
        assert!(doubts <= 400, "{doubts}");
        assert!(tanh_unfused([f64::NAN]).is_none());
    }
}
