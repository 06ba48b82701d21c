//! The arithmetic of a replay: operations on blocks of lanes, with their partials.

use crate::real::{Mask, Real};
use crate::record::operation::{Binary, Logic, Unary};
use crate::rule;

/// A number of the recording for `W * L::N` points.
pub(super) type Block<L, const W: usize> = [L; W];

#[inline(always)]
pub(super) fn add_product<L: Real, const W: usize>(
    factor: L,
    own: Block<L, W>,
    mut sum: Block<L, W>,
) -> Block<L, W> {
    for w in 0..W {
        sum[w] = own[w].fma(factor, sum[w]);
    }
    sum
}

#[inline(always)]
pub(super) fn chain<L: Real, const W: usize>(
    partial: Block<L, W>,
    bar: Block<L, W>,
) -> Block<L, W> {
    let mut part = bar;
    for w in 0..W {
        part[w] = L::chain(partial[w], bar[w]);
    }
    part
}

#[inline(always)]
pub(super) fn is_zero<L: Real, const W: usize>(block: Block<L, W>) -> bool {
    for w in 0..W {
        if !block[w].is_zero() {
            return false;
        }
    }
    true
}

/// Whether any lane's primal is zero.
#[inline(always)]
pub(super) fn has_zero<L: Real, const W: usize>(block: Block<L, W>) -> bool {
    let zero = L::zero();
    let mut found = L::Mask::splat(false);
    for w in 0..W {
        found = found | (block[w].le(zero) & zero.le(block[w]));
    }
    found.any()
}

/// A mask from the number that stands for it.
#[inline(always)]
pub(super) fn holds<L: Real>(mask: L) -> L::Mask {
    L::lit(0.5).lt(mask)
}

/// The number that stands for a mask.
#[inline(always)]
pub(super) fn number<L: Real>(mask: L::Mask) -> L {
    L::select(mask, L::one(), L::zero())
}

#[inline(always)]
pub(super) fn logic<L: Real>(f: Logic, a: L, b: L) -> L {
    let mask = match f {
        Logic::Lt => a.lt(b),
        Logic::Le => a.le(b),
        Logic::And => holds(a) & holds(b),
        Logic::Or => holds(a) | holds(b),
        Logic::Not => !holds(a),
    };
    number(mask)
}

/// The value and the partial.
#[inline(always)]
pub(super) fn unary<L: Real>(f: Unary, x: L) -> (L, L) {
    match f {
        Unary::Neg => (-x, -L::one()),
        Unary::Recip => rule::recip(x),
        Unary::Sqrt => rule::sqrt(x),
        Unary::Rsqrt => rule::rsqrt(x),
        Unary::Exp => rule::exp(x),
        Unary::Ln => rule::ln(x),
        Unary::Sin => rule::sin(x),
        Unary::Cos => rule::cos(x),
        Unary::Tan => rule::tan(x),
        Unary::Tanh => rule::tanh(x),
        Unary::Abs => rule::abs(x),
        Unary::Detach => (x.detach(), L::zero()),
        Unary::Powi(exponent) => rule::powi(x, exponent),
        Unary::Elementary(function) => function.rule(x),
    }
}

/// The value and the partials.
#[inline(always)]
fn binary<L: Real>(f: Binary, a: L, b: L) -> (L, [L; 2]) {
    let one = L::one();
    match f {
        Binary::Add => (a + b, [one, one]),
        Binary::Sub => (a - b, [one, -one]),
        Binary::Mul => rule::mul(a, b),
        Binary::Div => rule::div(a, b),
        Binary::Atan2 => rule::atan2(a, b),
        Binary::Powf => rule::powf(a, b),
        Binary::Hypot => rule::hypot(a, b),
        Binary::Chain => (L::chain(a, b), [b, a]),
        Binary::StraightThrough => (a.straight_through(b), [L::zero(), one]),
    }
}

/// The frequent operations have loops of their own, so that the match is outside of the loop.
#[inline(always)]
pub(super) fn forward_binary<L: Real, const W: usize>(
    f: Binary,
    a: Block<L, W>,
    b: Block<L, W>,
) -> Block<L, W> {
    let mut y = a;
    match f {
        Binary::Add => {
            for w in 0..W {
                y[w] = a[w] + b[w];
            }
        }
        Binary::Sub => {
            for w in 0..W {
                y[w] = a[w] - b[w];
            }
        }
        Binary::Mul => {
            for w in 0..W {
                y[w] = a[w] * b[w];
            }
        }
        _ => {
            for w in 0..W {
                y[w] = binary(f, a[w], b[w]).0;
            }
        }
    }
    y
}

#[inline(always)]
pub(super) fn reverse_binary<L: Real, const W: usize>(
    f: Binary,
    [a, b]: [Block<L, W>; 2],
    bar: Block<L, W>,
) -> [Block<L, W>; 2] {
    let mut parts = [bar; 2];
    match f {
        Binary::Add => {}
        Binary::Sub => {
            for w in 0..W {
                parts[1][w] = -bar[w];
            }
        }
        Binary::Mul => parts = [chain(b, bar), chain(a, bar)],
        _ => {
            for w in 0..W {
                let [by_a, by_b] = binary(f, a[w], b[w]).1;
                parts[0][w] = L::chain(by_a, bar[w]);
                parts[1][w] = L::chain(by_b, bar[w]);
            }
        }
    }
    parts
}
