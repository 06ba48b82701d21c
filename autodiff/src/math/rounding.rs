//! Constants, signs and rounding, composed of methods of [`Real`]. These functions select and do not branch, so they
//! run in lanes.

use crate::real::{Mask, Real};

#[inline(always)]
#[track_caller]
pub(crate) fn pi<R: Real>() -> R {
    R::zero().atan2(-R::one())
}

/// Returns (nearly) the machine epsilon: the distance from 1 to the next larger number of the type. It is computed as
/// the rounding error of `3 (4/3 - 1) - 1`, which is zero in exact arithmetic.
#[track_caller]
pub(crate) fn epsilon<R: Real>() -> R {
    let third = R::lit(4.0) / R::lit(3.0) - R::one();
    (R::lit(3.0) * third - R::one()).abs().detach()
}

/// Whether the number is negative or minus zero.
#[track_caller]
pub(crate) fn sign_bit<R: Real>(x: R) -> R::Mask {
    let zero = R::zero();
    let at_zero = x.less_equal(zero) & zero.less_equal(x);
    x.less(zero) | (at_zero & x.detach().recip().less(zero))
}

/// Returns the integer part as a constant, that is, without a derivative. The integer is built bit by bit, from the
/// highest bit down, so it is exact for any type.
#[track_caller]
pub(crate) fn truncated<R: Real>(x: R) -> R {
    let (zero, size, two, mut bit) = (R::zero(), x.abs().detach(), R::lit(2.0), R::one());
    let (finite, half) = (size.finite(), size / two);
    // `bit` is compared with half of `size`, so that it never exceeds `size` and cannot overflow.
    while (bit.less_equal(half) & finite).any() {
        bit *= two;
    }
    let mut whole = zero;
    while R::one().less_equal(bit).any() {
        let more = whole + bit;
        whole = R::select(more.less_equal(size), more, whole);
        bit /= two;
    }
    // Infinities, NaN and the sign of zero are kept.
    let whole = R::select(finite, whole, size);
    let whole = R::select(x.less(zero), -whole, whole);
    R::select(size.less_equal(zero), x.detach(), whole)
}

/// Returns the exact remainder (`fmod`) `a - q b`, where `q` is the integer part of `a / b`. Its derivative treats `q`
/// as a constant.
#[track_caller]
pub(crate) fn remainder<R: Real>(a: R, b: R) -> R {
    let (zero, divisor) = (R::zero(), b.detach().abs());
    let size = a.detach().abs();
    let defined = size.finite() & zero.less(divisor);
    // Long division. The divisor is scaled up by powers of `FAR` to just below the dividend. Then binary multiples of
    // each scaled divisor are subtracted. Every difference is exact.
    let far = R::lit(FAR);
    let (mut left, mut unit) = (size, divisor);
    loop {
        let grows = (unit * far).less_equal(size) & defined;
        if !grows.any() {
            break;
        }
        unit = R::select(grows, unit * far, unit);
    }
    loop {
        let mut times = FAR;
        while times >= 1.0 {
            let multiple = unit * R::lit(times);
            left = R::select(multiple.less_equal(left) & defined, left - multiple, left);
            times *= 0.5;
        }
        let larger = divisor.less(unit) & defined;
        if !larger.any() {
            break;
        }
        unit = R::select(larger, unit / far, unit);
    }
    let whole = round((size - left) / divisor);
    let value = R::select(sign_bit(a), -left, left);
    let value = R::select(defined, value, R::lit(f64::NAN));
    let whole = R::select(a.less(zero), -whole, whole);
    let whole = R::select(b.less(zero), -whole, whole);
    // If the quotient is 0, the derivative does not depend on the divisor, even if the divisor is infinite.
    let moves = R::select(whole.abs().less_equal(zero), a, a - b * whole);
    value.straight_through(moves)
}

/// A power of two whose square is finite in single precision.
const FAR: f64 = (1_u64 << 60) as f64;

#[track_caller]
pub(crate) fn floor<R: Real>(x: R) -> R {
    let whole = truncated(x);
    R::select(x.less(whole), whole - R::one(), whole)
}

/// Returns the nearest integer as a constant, that is, without a derivative. Halves are rounded away from zero.
#[track_caller]
pub(crate) fn round<R: Real>(x: R) -> R {
    let (whole, zero, one) = (truncated(x), R::zero(), R::one());
    let far = R::lit(0.5).less_equal((x - whole).abs());
    let away = R::select(x.less(zero), -one, one);
    R::select(far, whole + away, whole)
}
