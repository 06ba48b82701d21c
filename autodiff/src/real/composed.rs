//! Longer default methods of [`Real`].

use super::gamma::{FAR, Gamma, asymptotic, ln_sqrt_2_pi};
use super::{Mask, Real};

/// Implements [`Real::sum_of`]. The additions of one sixteen do not wait for those of the next.
#[inline(always)]
#[track_caller]
pub(super) fn sum_of<R: Real>(terms: &[R]) -> R {
    let (mut terms, mut few) = (terms, 128);
    let mut sums: Vec<R>;
    // Loops, because closures might be compiled without the instruction set of the lanes.
    while terms.len() > few {
        let mut next = Vec::with_capacity(terms.len().div_ceil(16));
        for sixteen in terms.chunks(16) {
            next.push(in_order(sixteen));
        }
        sums = next;
        (terms, few) = (&sums, 16);
    }
    in_order(terms)
}

#[inline(always)]
#[track_caller]
fn in_order<R: Real>(terms: &[R]) -> R {
    let mut sum = R::zero();
    for &term in terms {
        sum += term;
    }
    sum
}

/// A sum over a slice: `$sum` returns the sum over `$few` of its numbers. Up to 128 numbers are summed at once. Of more,
/// the sums of sixteen are added by [`Real::sum_of`]. This is a macro because a closure might be compiled without the
/// instruction set of the lanes.
macro_rules! by_parts {
    ($numbers:ident, |$few:ident| $sum:expr) => {
        if $numbers.len() <= 128 {
            let $few = $numbers;
            $sum
        } else {
            let mut sums = Vec::with_capacity($numbers.len().div_ceil(16));
            for $few in $numbers.chunks(16) {
                sums.push($sum);
            }
            R::sum_of(&sums)
        }
    };
}

/// Implements [`Real::norm`].
#[inline(always)]
#[track_caller]
pub(super) fn norm<R: Real>(x: &[R]) -> R {
    let (zero, one) = (R::zero(), R::one());
    let mut largest = zero;
    for &x in x {
        largest = x.detach().abs().max(largest);
    }
    let ordinary = R::lit(1e-15).less(largest) & largest.less(1e15);
    if R::Mask::IS_SINGLE && ordinary.all() {
        return by_parts!(x, |few| R::dot(few, few)).sqrt();
    }
    let scaled = !ordinary & zero.less(largest) & largest.finite();
    let unit = R::select(scaled, largest, one);
    // The inverse of a subnormal unit is infinite. That of a multiple is finite, and the squares do not underflow.
    let multiple = unit * R::lit((1_u64 << 54) as f64);
    let unit = R::select(unit.recip().finite(), unit, multiple);
    let sum = by_parts!(x, |few| {
        let mut sum = zero;
        for &x in few {
            let x = x / unit;
            sum = x.fma(x, sum);
        }
        sum
    });
    let origin = sum.less_equal(zero);
    R::select(origin, zero, R::select(origin, one, sum).sqrt() * unit)
}

/// Implements [`Real::logsumexp`].
#[inline(always)]
#[track_caller]
pub(super) fn logsumexp<R: Real>(x: &[R]) -> R {
    let Some((&first, others)) = x.split_first() else {
        return R::lit(f64::NEG_INFINITY);
    };
    let (zero, one) = (R::zero(), R::one());
    let mut top = first;
    for &x in others {
        top = R::select(top.less(x), x, top);
    }
    // The sum of the powers is `e^top (1 + rest)`. The rest lacks the first term that is as large as `top`.
    let (held, mut found) = (top.detach(), R::Mask::splat(false));
    let rest = by_parts!(x, |few| {
        let mut rest = zero;
        for &x in few {
            let same = x.less_equal(held) & held.less_equal(x);
            let (first, endless) = (same & !found, !held.finite() & !x.finite());
            let ordered = x.less_equal(held) | held.less_equal(x);
            found = found | same;
            let skipped = first | (endless & ordered);
            if R::Mask::IS_SINGLE && skipped.any() {
                continue;
            }
            rest += R::select(skipped, zero, (x - held).exp());
        }
        rest
    });
    // The powers of `top - held` are 1, and only move. In both forms no derivative is a small difference of large
    // numbers: that of the largest term is `1 - rest / (1 + rest)` if the rest is small, otherwise `1 / (1 + rest)`.
    let large = one.less(rest);
    let power = R::select(large, top - held, held - top).exp();
    let more = R::select(large, rest - one + power, rest * power).ln_1p();
    let value = R::select(large, held, top) + more;
    R::select(top.finite() | !rest.less_equal(rest), value, top)
}

/// Implements [`Real::ln_beta`].
#[inline(always)]
#[track_caller]
pub(super) fn ln_beta<R: Real>(a: R, b: R) -> R {
    let (first, half) = (a.less(b), R::lit(0.5));
    let (p, q) = (R::select(first, a, b), R::select(first, b, a));
    let p = R::select(p.less(0.0), p * R::lit(f64::NAN), p);
    let (sum, far) = (p + q, R::lit(FAR).less_equal(q));
    let of_p = p.ln_gamma();
    let near = of_p + (q.ln_gamma() - sum.ln_gamma());
    if R::Mask::IS_SINGLE && !far.any() {
        return near;
    }
    // The distances of `ln_gamma` from Stirling's formula, for numbers of at least 16.
    let mut rests = [p, q, sum];
    for rest in &mut rests {
        let inverse = rest.recip();
        *rest = asymptotic(Gamma::Ln, inverse * inverse) * inverse;
    }
    let ([by_p, by_q, by_sum], share) = (rests, p / sum);
    let ln_rest = (-share).ln_1p();
    let constant = by_p + (by_q - by_sum) + ln_sqrt_2_pi::<R>() - half * q.ln();
    let both = constant + (p - half) * share.ln() + q * ln_rest;
    let one = of_p + (by_q - by_sum) + (p - p * sum.ln()) + (q - half) * ln_rest;
    let value = R::select(R::lit(FAR).less_equal(p), both, one);
    let value = R::select(q.finite(), value, -q);
    R::select(far, value, near)
}
