//! The hyperbolic tangent in lanes without a fused multiply-add. It detects the rare cases in which a result may not
//! have the bits of fused multiply-adds.
//!
//! A hyperbolic tangent needs seventeen fused multiply-adds. In software each takes some sixty instructions; here one
//! takes twenty instructions for all lanes. The product and the sum are computed together with their rounding errors
//! (Dekker 1971). Then the final sum is rounded twice, with a slightly larger and with a slightly smaller error (Ziv
//! 1991). If both give the same result, it is the fused result. Otherwise, about once in ten thousand times, everything
//! is computed again in software. In WebAssembly this takes 21 ns instead of 190.

use std::ops::{Add, Div, Mul, Sub};

use crate::math::{Primitive, tanh_abreast};
use crate::real::{Mask, Real};

/// Lanes without an instruction for a fused multiply-add.
pub(super) trait Unfused: Real + Primitive {
    /// Returns `self * b + c`, rounded once, and a mask of the lanes in which the rounding may be wrong. Nothing may
    /// overflow. The mask is only valid if the product is not larger than `c`, or if `c` is zero, or if the sum is
    /// exact.
    fn fused(self, b: Self, c: Self) -> (Self, Self::Mask);
}

/// Returns the hyperbolic tangents of several registers with the bits of fused multiply-adds, or `None` if a bit may be
/// wrong. This function and the ones below use loops instead of closures, because some closures are not inlined.
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

/// A register of numbers, and a mask of the lanes in which the bits may differ from those of fused multiply-adds.
#[derive(Clone, Copy)]
struct Doubted<L: Real> {
    value: L,
    doubt: L::Mask,
}

/// The relative amount by which the rounding error is made larger and smaller. This amount is larger than the
/// inaccuracy of the rounding error. It is also so small that it rarely changes a result: only for sums very close to
/// the midpoint between two floats.
const MARGIN: f64 = 1.0 / (1 << 20) as f64;

/// Splits a number into a sum of two numbers with half the digits each (Veltkamp 1968).
#[inline(always)]
fn halves<L: Real>(a: L) -> [L; 2] {
    let scaled = a * L::lit((1 << 27) as f64 + 1.0);
    let high = scaled - (scaled - a);
    [high, a - high]
}

/// Computes `a * b + c` in double precision twice, rounded once each time: first with a slightly larger rounding error,
/// then with a slightly smaller one. `upper` must be `a` with the lower 27 of its 53 digits set to zero.
#[inline(always)]
pub(super) fn around<L: Real>(a: L, upper: L, b: L, c: L) -> [L; 2] {
    // `b` is split here, because several products share it and its halves. For `a`, clearing digits takes fewer
    // instructions.
    let [high, low] = halves(b);
    let product = a * b;
    // The rounding error of the product: at most 2^-53 of the product, with an error below 2^-75 of it. It is exact if
    // `a` is short.
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

    /// Wraps a value that was computed from `self` and `others`. A lane of the result is in doubt if that lane of
    /// `self` or of any of `others` is.
    #[inline(always)]
    fn to<const N: usize>(mut self, value: L, others: [Self; N]) -> Self {
        self.value = value;
        for n in 0..N {
            self.doubt = self.doubt | others[n].doubt;
        }
        self
    }
}

/// Defines operators. They round only once, so the result is in doubt only if an operand is.
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

    /// At most 400 of 200 000 arguments of all sizes may be doubtful. All others must have the bits of fused
    /// multiply-adds.
    #[test]
    fn results_are_fused_or_doubtful() {
        let mut doubts = 0;
        for k in 0..100_000 {
            let t = f64::from(k) / 100_000.0;
            // From 20 on `tanh` is 1. `other` has short numbers, whose sums are ties more often, and the smallest
            // numbers.
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
