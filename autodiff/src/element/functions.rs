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

/// The remainder of `a / b` less its fraction: exact, with the derivative for that whole quotient.
pub(crate) fn remainder<R: Real>(a: R, b: R) -> R {
    let (zero, divisor) = (R::zero(), b.detach().abs());
    let size = a.detach().abs();
    let defined = size.finite() & zero.lt(divisor);
    // Far apart as the two may be, no multiple of the divisor is more than this above the next.
    let far = R::lit(FAR);
    let (mut left, mut unit) = (size, divisor);
    loop {
        let grows = (unit * far).le(size) & defined;
        if !grows.any() {
            break;
        }
        unit = R::select(grows, unit * far, unit);
    }
    loop {
        let mut times = FAR;
        while times >= 1.0 {
            let multiple = unit * R::lit(times);
            left = R::select(multiple.le(left) & defined, left - multiple, left);
            times *= 0.5;
        }
        let larger = divisor.lt(unit) & defined;
        if !larger.any() {
            break;
        }
        unit = R::select(larger, unit / far, unit);
    }
    let whole = round((size - left) / divisor);
    let value = R::select(sign_bit(a), -left, left);
    let value = R::select(defined, value, R::lit(f64::NAN));
    let whole = R::select(a.lt(zero), -whole, whole);
    let whole = R::select(b.lt(zero), -whole, whole);
    // A divisor that fits in no time has no part in the derivative, infinite as it may be.
    let moves = R::select(whole.abs().le(zero), a, a - b * whole);
    value.straight_through(moves)
}

/// A power of two whose own is a number of single precision.
const FAR: f64 = (1_u64 << 60) as f64;

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
