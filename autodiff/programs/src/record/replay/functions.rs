//! Functions of one or two numbers and their partials, on blocks of lanes.

use autodiff::Real;
use autodiff::internal::rule;
use autodiff::simd::Lane;

use super::block::{Block, chain};
use super::elementwise::{Elementwise, Function};
use crate::arrays::Aligned;
use crate::record::operation::{Binary, Unary};

/// Returns the values and the partials of a function of one number. The partials are only valid if `differentiates` is
/// true. Short functions have their own loops. All others are compiled once for all block lengths.
#[inline(always)]
pub(super) fn forward_unary<R: Real, L: Lane<R>, const W: usize>(
    (f, differentiates): (Unary, bool),
    x: Block<L, W>,
    memory: &mut Aligned<R>,
) -> (Block<L, W>, Block<L, W>) {
    let (mut y, mut partials) = (x, x);
    match f {
        Unary::Neg => {
            for w in 0..W {
                (y[w], partials[w]) = (-x[w], -L::one());
            }
        }
        Unary::Recip => {
            for w in 0..W {
                (y[w], partials[w]) = rule::recip(x[w]);
            }
        }
        Unary::Sqrt => {
            for w in 0..W {
                (y[w], partials[w]) = rule::sqrt(x[w]);
            }
        }
        Unary::Abs => {
            for w in 0..W {
                (y[w], partials[w]) = rule::abs(x[w]);
            }
        }
        Unary::Detach => {
            for w in 0..W {
                (y[w], partials[w]) = (x[w].detach(), L::zero());
            }
        }
        _ if differentiates => [y, partials] = Elementwise::apply(Function::Unary(f), [x], memory),
        _ => [y] = Elementwise::apply(Function::UnaryValue(f), [x], memory),
    }
    (y, partials)
}

/// Returns the values of a function of two numbers. Frequent operations have their own loops, so that the `match` is
/// outside of the loop.
#[inline(always)]
pub(super) fn forward_binary<R: Real, L: Lane<R>, const W: usize>(
    f: Binary,
    [a, b]: [Block<L, W>; 2],
    memory: &mut Aligned<R>,
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
        Binary::Div => {
            for w in 0..W {
                y[w] = a[w] / b[w];
            }
        }
        _ => [y] = Elementwise::apply(Function::BinaryValue(f), [a, b], memory),
    }
    y
}

/// Returns the cotangents of both arguments of a function of two numbers.
#[inline(always)]
pub(super) fn reverse_binary<R: Real, L: Lane<R>, const W: usize>(
    f: Binary,
    [a, b]: [Block<L, W>; 2],
    bar: Block<L, W>,
    memory: &mut Aligned<R>,
) -> [Block<L, W>; 2] {
    let mut parts = [bar; 2];
    match f {
        Binary::Add => {}
        Binary::Sub => {
            for w in 0..W {
                parts[1][w] = -bar[w];
            }
        }
        Binary::Mul | Binary::Chain => parts = [chain(b, bar), chain(a, bar)],
        _ => {
            let [_, by_a, by_b] = Elementwise::apply(Function::Binary(f), [a, b], memory);
            parts = [chain(by_a, bar), chain(by_b, bar)];
        }
    }
    parts
}
