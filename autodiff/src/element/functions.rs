//! Signs and rounding, made of what a [`Real`] has. No branch is taken by a jump, so they run in
//! lanes.

use crate::real::{Mask, Real};

pub(crate) fn pi<R: Real>() -> R {
    R::zero().atan2(-R::one())
}

/// Whether the number is negative, or the negative zero.
pub(crate) fn sign_bit<R: Real>(x: R) -> R::Mask {
    let zero = R::zero();
    let at_zero = x.le(zero) & zero.le(x);
    x.lt(zero) | (at_zero & x.detach().recip().lt(zero))
}

/// Without its fraction, as a constant. Bit by bit, from the highest down: exact in any type.
pub(crate) fn truncated<R: Real>(x: R) -> R {
    let (zero, size, two, mut bit) = (R::zero(), x.abs().detach(), R::lit(2.0), R::one());
    let (finite, half) = (size.finite(), size / two);
    // The highest bit is no higher than the number: it is finite.
    while (bit.le(half) & finite).any() {
        bit *= two;
    }
    let mut whole = zero;
    while R::one().le(bit).any() {
        let more = whole + bit;
        whole = R::select(more.le(size), more, whole);
        bit /= two;
    }
    // Infinities and NaN stay, and the sign of zero does.
    let whole = R::select(finite, whole, size);
    let whole = R::select(x.lt(zero), -whole, whole);
    R::select(size.le(zero), x.detach(), whole)
}

pub(crate) fn floor<R: Real>(x: R) -> R {
    let whole = truncated(x);
    R::select(x.lt(whole), whole - R::one(), whole)
}

/// Halves away from zero.
pub(crate) fn round<R: Real>(x: R) -> R {
    let (whole, zero, one) = (truncated(x), R::zero(), R::one());
    let far = R::lit(0.5).le((x - whole).abs());
    let away = R::select(x.lt(zero), -one, one);
    R::select(far, whole + away, whole)
}
