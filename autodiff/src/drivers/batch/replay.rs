//! Replaying a recording forward and back, a block of points at a time.
//!
//! Each number of the recording is a few registers wide: then the dispatch on an operation costs little
//! beside the operation.

use super::block::{Block, add_product, chain, forward_binary, has_zero, is_zero, reverse_binary};
use crate::pool;
use crate::real::{Mask, Real};
use crate::record::arithmetic::{holds, logic, number, unary};
use crate::record::operation::{Binary, Op, Place, Unary};
use crate::simd::{Lane, WIDEST};

/// Registers for each number, where there are points enough to fill them.
pub(super) const WIDE: usize = 4;

/// The operations of a recording with the numbers that they are replayed on.
pub(super) struct Replay<'a, R, L, const W: usize> {
    ops: &'a [Op],
    /// How many operations are inputs. They come first.
    inputs: usize,
    memory: Box<ReplayBuffers<R, L, W>>,
}

struct ReplayBuffers<R, L, const W: usize> {
    /// The arguments that all points share.
    shared: Vec<R>,
    /// Their cotangents, in each lane summed over its points.
    shared_bars: Vec<L>,
    /// Each operation's result.
    values: Vec<Block<L, W>>,
    /// Each result's cotangent.
    bars: Vec<Block<L, W>>,
    /// The partials of functions of one number, from the forward to the reverse sweep.
    partials: Vec<Block<L, W>>,
}

impl<'a, R: Real, L: Lane<R>, const W: usize> Replay<'a, R, L, W> {
    /// Reuses the memory of the thread's last replay of this number type.
    #[inline(always)]
    pub(super) fn new(ops: &'a [Op], inputs: usize, shared: &[R]) -> Self {
        let mut memory = pool::take::<ReplayBuffers<R, L, W>>().unwrap_or_else(|| {
            Box::new(ReplayBuffers {
                shared: Vec::new(),
                shared_bars: Vec::new(),
                values: Vec::new(),
                bars: Vec::new(),
                partials: Vec::new(),
            })
        });
        memory.shared.clear();
        memory.shared.extend_from_slice(shared);
        let zero = [L::zero(); W];
        memory.shared_bars.clear();
        memory.shared_bars.resize(shared.len(), L::zero());
        memory.bars.clear();
        memory.bars.resize(ops.len(), zero);
        // These are written before they are read.
        memory.values.resize(ops.len(), zero);
        memory.partials.resize(ops.len(), zero);
        for (value, op) in memory.values.iter_mut().zip(ops) {
            match *op {
                Op::Constant(bits) => *value = [L::lit(f64::from_bits(bits)); W],
                Op::Always(holds) => *value = [number(L::Mask::splat(holds)); W],
                _ => {}
            }
        }
        Self {
            ops,
            inputs,
            memory,
        }
    }

    /// The inputs of the next block.
    #[inline(always)]
    pub(super) fn inputs(&mut self) -> &mut [Block<L, W>] {
        &mut self.memory.values[..self.inputs]
    }

    /// The cotangents of the shared arguments, all points together.
    #[inline(always)]
    pub(super) fn into_gradient(self) -> Vec<R> {
        let mut lanes = [R::zero(); WIDEST];
        let mut totals = Vec::with_capacity(self.memory.shared_bars.len());
        for bar in &self.memory.shared_bars {
            bar.store(&mut lanes);
            totals.push(R::sum_of(&lanes[..L::N]));
        }
        pool::keep(self.memory);
        totals
    }

    #[inline(always)]
    fn get(&self, place: Place) -> Block<L, W> {
        if place.is_shared() {
            [L::splat(self.memory.shared[place.at()]); W]
        } else {
            self.memory.values[place.at()]
        }
    }

    /// Adds to the cotangent of a place, unless it is one of the data, whose cotangents nobody reads.
    #[inline(always)]
    fn add(&mut self, place: Place, part: Block<L, W>) {
        if place.is_shared() {
            let bar = &mut self.memory.shared_bars[place.at()];
            for w in 0..W {
                *bar += part[w];
            }
        } else if place.at() >= self.inputs {
            let bar = &mut self.memory.bars[place.at()];
            for w in 0..W {
                bar[w] += part[w];
            }
        }
    }

    /// Computes all operations and returns the result.
    #[inline(always)]
    pub(super) fn forward(&mut self, result: Place) -> Block<L, W> {
        let mut y = [L::zero(); W];
        for (place, op) in self.ops.iter().enumerate().skip(self.inputs) {
            match *op {
                Op::Input(_) | Op::Constant(_) | Op::Always(_) => continue,
                Op::Unary(f, x) => {
                    let x = self.get(x);
                    let partials = &mut self.memory.partials[place];
                    for w in 0..W {
                        (y[w], partials[w]) = unary(f, x[w]);
                    }
                }
                Op::Binary(f, [a, b]) => y = forward_binary(f, self.get(a), self.get(b)),
                Op::Fma([a, b, c]) => {
                    let (a, b, c) = (self.get(a), self.get(b), self.get(c));
                    for w in 0..W {
                        y[w] = a[w].fma(b[w], c[w]);
                    }
                }
                Op::Logic(f, [a, b]) => {
                    let (a, b) = (self.get(a), self.get(b));
                    for w in 0..W {
                        y[w] = logic(f, a[w], b[w]);
                    }
                }
                Op::Select(mask, [a, b]) => {
                    let (mask, a, b) = (self.get(mask), self.get(a), self.get(b));
                    for w in 0..W {
                        y[w] = L::select(holds(mask[w]), a[w], b[w]);
                    }
                }
                Op::Dot([a, b], len) => y = self.forward_dot(a, b, len as usize),
                Op::Sum(x, len) => y = self.forward_sum(x, len as usize),
            }
            self.memory.values[place] = y;
        }
        self.get(result)
    }

    #[inline(always)]
    fn forward_dot(&self, a: Place, b: Place, len: usize) -> Block<L, W> {
        let mut y = [L::zero(); W];
        if a.is_shared() && !b.is_shared() {
            let (a, b) = (
                &self.memory.shared[a.at()..][..len],
                &self.memory.values[b.at()..][..len],
            );
            // Two at a time: the loop itself costs as much as the work on one.
            let ((a, a_last), (b, b_last)) = (a.as_chunks::<2>(), b.as_chunks::<2>());
            for (factors, own) in a.iter().zip(b) {
                for k in 0..2 {
                    y = add_product(L::splat(factors[k]), own[k], y);
                }
            }
            for (&factor, &own) in a_last.iter().zip(b_last) {
                y = add_product(L::splat(factor), own, y);
            }
            return y;
        }
        for j in 0..len {
            let (a, b) = (self.get(a.plus(j)), self.get(b.plus(j)));
            for w in 0..W {
                y[w] = a[w].fma(b[w], y[w]);
            }
        }
        y
    }

    #[inline(always)]
    fn forward_sum(&self, x: Place, len: usize) -> Block<L, W> {
        let mut y = [L::zero(); W];
        for j in 0..len {
            let x = self.get(x.plus(j));
            for w in 0..W {
                y[w] += x[w];
            }
        }
        y
    }

    /// Carries the cotangent of the result back to the shared arguments. The cotangents of operations are
    /// zero before and after.
    #[inline(always)]
    pub(super) fn reverse(&mut self, result: Place, bar: Block<L, W>) {
        self.add(result, bar);
        let mut place = self.ops.len();
        while place > self.inputs {
            place -= 1;
            let bar = self.memory.bars[place];
            if is_zero(bar) {
                continue;
            }
            self.memory.bars[place] = [L::zero(); W];
            match self.ops[place] {
                Op::Input(_) | Op::Constant(_) | Op::Always(_) | Op::Logic(..) => {}
                // No product with zero: an infinite cotangent would be NaN where it does not pass.
                Op::Unary(Unary::Detach, _) => {}
                Op::Unary(_, x) => self.add(x, chain(self.memory.partials[place], bar)),
                Op::Binary(Binary::StraightThrough, [_, soft]) => self.add(soft, bar),
                Op::Binary(f, [a, b]) => {
                    let parts = reverse_binary(f, [self.get(a), self.get(b)], bar);
                    self.add(a, parts[0]);
                    self.add(b, parts[1]);
                }
                Op::Fma([a, b, c]) => {
                    let parts = [chain(self.get(b), bar), chain(self.get(a), bar)];
                    self.add(a, parts[0]);
                    self.add(b, parts[1]);
                    self.add(c, bar);
                }
                Op::Select(mask, [a, b]) => {
                    let (mask, mut parts) = (self.get(mask), [bar; 2]);
                    for w in 0..W {
                        // No products here either.
                        parts[0][w] = L::select(holds(mask[w]), bar[w], L::zero());
                        parts[1][w] = L::select(holds(mask[w]), L::zero(), bar[w]);
                    }
                    self.add(a, parts[0]);
                    self.add(b, parts[1]);
                }
                Op::Dot(x, len) => {
                    if self.reverse_dot(place, x, len as usize, bar) {
                        place -= 1;
                    }
                }
                Op::Sum(x, len) => {
                    for j in 0..len as usize {
                        self.add(x.plus(j), bar);
                    }
                }
            }
        }
    }

    /// Carries back a dot product, the operation at `place`. If the operation before is the product of
    /// another shared row with the same own numbers, as in a matrix times a vector, carries that back
    /// too, and returns true.
    #[inline(always)]
    fn reverse_dot(
        &mut self,
        place: usize,
        [a, b]: [Place; 2],
        len: usize,
        bar: Block<L, W>,
    ) -> bool {
        if a == b {
            let mut twice = bar;
            for w in 0..W {
                twice[w] += bar[w];
            }
            for j in 0..len {
                let x = a.plus(j);
                self.add(x, chain(self.get(x), twice));
            }
            return false;
        }
        if !a.is_shared() || b.is_shared() || has_zero(bar) {
            for j in 0..len {
                let (a, b) = (a.plus(j), b.plus(j));
                let parts = [chain(self.get(b), bar), chain(self.get(a), bar)];
                self.add(a, parts[0]);
                self.add(b, parts[1]);
            }
            return false;
        }
        // Two rows at a time: their numbers and the cotangents of these are loaded and stored once.
        if place > 0
            && let Op::Dot(x, len_before) = self.ops[place - 1]
            && (x[0].is_shared(), x[1]) == (true, b)
            && b.at() + len < place
        {
            let before = self.memory.bars[place - 1];
            if !has_zero(before) {
                self.memory.bars[place - 1] = [L::zero(); W];
                let len_before = len_before as usize;
                let both = len.min(len_before);
                self.reverse_rows([a.at(), x[0].at()], b.at(), both, [bar, before]);
                self.reverse_rows([a.at() + both], b.at() + both, len - both, [bar]);
                let rest = len_before - both;
                self.reverse_rows([x[0].at() + both], b.at() + both, rest, [before]);
                return true;
            }
        }
        self.reverse_rows([a.at()], b.at(), len, [bar]);
        false
    }

    /// Carries back the dot products of `D` shared rows of `len` numbers, which begin at `a`, with the
    /// same own numbers from `b` on, given cotangents none of which is zero.
    #[inline(always)]
    fn reverse_rows<const D: usize>(
        &mut self,
        a: [usize; D],
        b: usize,
        len: usize,
        bars: [Block<L, W>; D],
    ) {
        if len == 0 {
            return;
        }
        let ReplayBuffers {
            shared,
            shared_bars,
            values,
            bars: own_bars,
            ..
        } = &mut *self.memory;
        let (b, b_bar) = (&values[b..][..len], &mut own_bars[b..][..len]);
        let mut rows = [&shared[..0]; D];
        for d in 0..D {
            rows[d] = &shared[a[d]..][..len];
        }
        for j in 0..len {
            let (own, mut own_bar) = (b[j], b_bar[j]);
            for d in 0..D {
                let (factor, mut shared_bar) = (L::splat(rows[d][j]), shared_bars[a[d] + j]);
                for w in 0..W {
                    shared_bar = bars[d][w].fma(own[w], shared_bar);
                    own_bar[w] = bars[d][w].fma(factor, own_bar[w]);
                }
                shared_bars[a[d] + j] = shared_bar;
            }
            b_bar[j] = own_bar;
        }
    }
}
