//! Blocks: a few registers that are processed together.

use autodiff::simd::Lane;
use autodiff::{Mask, Real};

/// The values of one recorded number at `W * L::N` points: `W` registers of `L::N` lanes.
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
        part[w] = if const { size_of::<L>() > LARGE } {
            chain_large(partial[w], bar[w])
        } else {
            L::chain(partial[w], bar[w])
        };
    }
    part
}

/// The size of the widest register in bytes. Products of larger numbers, such as duals, are not inlined, because every
/// inlined copy would be long.
const LARGE: usize = 64;

#[inline(never)]
fn chain_large<L: Real>(partial: L, bar: L) -> L {
    L::chain(partial, bar)
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

/// Whether the value of any lane is zero.
#[inline(always)]
pub(super) fn has_zero<L: Real, const W: usize>(block: Block<L, W>) -> bool {
    let zero = L::zero();
    let mut found = L::Mask::splat(false);
    for w in 0..W {
        found = found | (block[w].less_equal(zero) & zero.less_equal(block[w]));
    }
    found.any()
}

/// Loads the block with the index `place`.
#[inline(always)]
pub(super) fn load<R: Real, L: Lane<R>, const W: usize>(from: &[R], place: usize) -> Block<L, W> {
    let (from, mut block) = (&from[place * (W * L::N)..][..W * L::N], [L::zero(); W]);
    for w in 0..W {
        block[w] = L::load(&from[w * L::N..]);
    }
    block
}

/// Stores a block at the index `place`.
#[inline(always)]
pub(super) fn store<R: Real, L: Lane<R>, const W: usize>(
    to: &mut [R],
    place: usize,
    block: Block<L, W>,
) {
    let to = &mut to[place * (W * L::N)..][..W * L::N];
    for w in 0..W {
        block[w].store(&mut to[w * L::N..]);
    }
}
