//! The arithmetic of a replay: operations on blocks of lanes, with their partials.

use crate::real::{Mask, Real};
use crate::record::arithmetic::binary;
use crate::record::operation::Binary;

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
        found = found | (block[w].less_equal(zero) & zero.less_equal(block[w]));
    }
    found.any()
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
