//! Elementary functions that a [`Real`] does not have, made of those it has.
//!
//! No constant but integers goes in, so they are as precise as the type; and no branch is taken
//! by a jump, so they run in lanes.

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
    let (size, two, mut bit) = (x.abs().detach(), R::lit(2.0), R::one());
    let finite = size.finite();
    while (bit.le(size) & finite & bit.finite()).any() {
        bit *= two;
    }
    let mut whole = R::zero();
    while R::one().le(bit).any() {
        let more = whole + bit;
        whole = R::select(more.le(size), more, whole);
        bit /= two;
    }
    // Infinities and NaN stay.
    let whole = R::select(finite, whole, size);
    R::select(x.lt(R::zero()), -whole, whole)
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

/// Cubic root of either sign.
pub(crate) fn cbrt<R: Real>(x: R) -> R {
    let negative = x.lt(R::zero());
    let root = R::select(negative, -x, x).powf(R::lit(3.0).recip());
    R::select(negative, -root, root)
}

pub(crate) fn asin<R: Real>(x: R) -> R {
    x.atan2(((R::one() - x) * (R::one() + x)).sqrt())
}

pub(crate) fn acos<R: Real>(x: R) -> R {
    ((R::one() - x) * (R::one() + x)).sqrt().atan2(x)
}

/// `2 t / (1 - t)` with `t = tanh(x/2)`, where nothing cancels for small `x`.
pub(crate) fn exp_m1<R: Real>(x: R) -> R {
    let one = R::one();
    let t = (x * R::lit(0.5)).tanh();
    R::select(x.abs().lt(one), (t + t) / (one - t), x.exp() - one)
}

/// W. Kahan's: `u = 1 + x` is rounded, and `x / (u - 1)` makes up for it.
pub(crate) fn ln_1p<R: Real>(x: R) -> R {
    let one = R::one();
    let u = one + x;
    let stands_for = u - one;
    let unmoved = stands_for.abs().le(R::zero());
    let whole = stands_for.finite();
    let corrected = R::select(whole, u.ln() * (x / stands_for), u.ln());
    R::select(unmoved, x, corrected)
}

pub(crate) fn sinh<R: Real>(x: R) -> R {
    R::lit(0.5) * (exp_m1(x) - exp_m1(-x))
}

pub(crate) fn cosh<R: Real>(x: R) -> R {
    R::lit(0.5) * (x.exp() + (-x).exp())
}

/// `ln(x + sqrt(x^2 + 1))`, of the magnitude, where nothing cancels.
pub(crate) fn asinh<R: Real>(x: R) -> R {
    let (one, negative) = (R::one(), x.lt(R::zero()));
    let size = R::select(negative, -x, x);
    let value = ln_1p(size + size * size / (one + (size * size + one).sqrt()));
    R::select(negative, -value, value)
}

pub(crate) fn acosh<R: Real>(x: R) -> R {
    let above = x - R::one();
    ln_1p(above + (above * (x + R::one())).sqrt())
}

pub(crate) fn atanh<R: Real>(x: R) -> R {
    R::lit(0.5) * (ln_1p(x) - ln_1p(-x))
}
