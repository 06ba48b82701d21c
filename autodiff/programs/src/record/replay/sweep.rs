//! Replays a recording forward and in reverse, for a block of points at a time.
//!
//! A block is a few registers wide, so that deciding which operation comes next costs little compared with the
//! operation.

use autodiff::Real;
use autodiff::internal::{WIDEST, begin_line, pool};
use autodiff::simd::Lane;

use super::block::{Block, add_product, chain, has_zero, is_zero};
use super::buffers::ReplayBuffers;
use super::functions::{forward_binary, forward_unary, reverse_binary};
use super::plan::{Plan, Step};
use crate::record::arithmetic::{holds, logic};
use crate::record::operation::{Binary, Op, Place, Run, Unary};

/// The number of registers in a block, if there are enough points to fill them.
pub(super) const WIDE: usize = 4;

/// A running replay: its plan and the numbers that it computes.
pub(super) struct Replay<'a, R, L, const W: usize> {
    plan: &'a Plan,
    /// The arguments that all points share.
    shared: &'a [R],
    /// If no cotangents of inputs are needed, the number of inputs; otherwise 0. Inputs are the first operations of the
    /// recording.
    inputs: usize,
    /// Whether [`reverse`](Self::reverse) will be called.
    differentiates: bool,
    memory: Box<ReplayBuffers<R, L, W>>,
}

impl<'a, R: Real, L: Lane<R>, const W: usize> Replay<'a, R, L, W> {
    /// Prepares a replay. Uses the buffers of the thread's last replay of this number type.
    #[inline(always)]
    pub(super) fn new(
        plan: &'a Plan,
        inputs: usize,
        shared: &'a [R],
        differentiates: bool,
    ) -> Self {
        let memory = ReplayBuffers::taken(plan, shared);
        Self {
            plan,
            shared,
            inputs,
            differentiates,
            memory,
        }
    }

    /// Sets the values of an input at the next block of points.
    #[inline(always)]
    pub(super) fn set_input(&mut self, input: usize, block: Block<L, W>) {
        self.memory.values[input] = block;
    }

    /// Returns the cotangent of an input and resets it to zero. Call this once for each block, and only if the
    /// cotangent is needed.
    #[inline(always)]
    pub(super) fn take_input_bar(&mut self, input: usize) -> Block<L, W> {
        std::mem::replace(&mut self.memory.partials[input], [L::zero(); W])
    }

    /// Returns the cotangents of the shared arguments, summed over all points.
    #[inline(always)]
    pub(super) fn into_gradient(mut self) -> Vec<R> {
        self.memory.take_settled();
        let mut lanes = [R::zero(); WIDEST];
        let mut gradient = std::mem::take(&mut self.memory.gradient);
        for (number, bar) in self.memory.read_bars.iter().enumerate() {
            bar.store(&mut lanes);
            let at = self.plan.read.as_ref().map_or(number, |read| read[number]);
            gradient[at] += R::sum_of(&lanes[..L::N]);
        }
        pool::keep(self.memory);
        gradient
    }

    /// Call this after every 128 points of a lane.
    #[inline(always)]
    pub(super) fn settle(&mut self) {
        self.memory.settle();
    }

    #[inline(always)]
    fn get(&self, place: Place) -> Block<L, W> {
        if place.is_shared() {
            [L::splat(self.memory.read[place.at()]); W]
        } else {
            self.memory.values[place.at()]
        }
    }

    /// Adds to the cotangent of the number at `place`. Does nothing for an input whose cotangent is not needed.
    #[inline(always)]
    fn add(&mut self, place: Place, part: Block<L, W>) {
        if place.is_shared() {
            let bar = &mut self.memory.read_bars[place.at()];
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

    #[inline(always)]
    fn add_both(&mut self, places: [Place; 2], parts: [Block<L, W>; 2]) {
        self.add(places[0], parts[0]);
        self.add(places[1], parts[1]);
    }

    /// Computes all operations at a block of points.
    #[inline(always)]
    pub(super) fn forward(&mut self) {
        let mut y = [L::zero(); W];
        for place in self.inputs..self.plan.steps.len() {
            if const { !R::IS_FLOAT } {
                begin_line(self.plan.lines[place]);
            }
            let op = match &self.plan.steps[place] {
                Step::Single(op) => op,
                Step::Layer(number) => {
                    self.memory
                        .forward_layer(self.plan.layers[*number], self.shared);
                    continue;
                }
                Step::Nothing => continue,
            };
            match *op {
                Op::Input(_) | Op::Constant(_) | Op::Always(_) => continue,
                Op::Unary(f, x) => {
                    let x = self.get(x);
                    let memory = &mut *self.memory;
                    let f = (f, self.differentiates);
                    (y, memory.partials[place]) = forward_unary(f, x, &mut memory.rows);
                }
                Op::Binary(f, [a, b]) => {
                    let (a, b) = (self.get(a), self.get(b));
                    y = forward_binary(f, [a, b], &mut self.memory.rows);
                }
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
    }

    /// Returns the values of a result at the points of the block that [`forward`](Self::forward) has computed last.
    #[inline(always)]
    pub(super) fn result(&self, result: usize) -> Block<L, W> {
        self.get(self.plan.results[result])
    }

    /// Adds to the cotangent of a result. Call this before [`reverse`](Self::reverse).
    #[inline(always)]
    pub(super) fn seed(&mut self, result: usize, bar: Block<L, W>) {
        self.add(self.plan.results[result], bar);
    }

    #[inline(always)]
    fn forward_dot(&self, a: Run, b: Run, len: usize) -> Block<L, W> {
        let mut y = [L::zero(); W];
        if a.is_row() && b.is_adjacent() && !b.first.is_shared() {
            let (a, b) = (
                &self.memory.read[a.first.at()..][..len],
                &self.memory.values[b.first.at()..][..len],
            );
            // Adds two products in each turn, because the loop itself costs as much as one product.
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
            let (a, b) = (self.get(a.at(j)), self.get(b.at(j)));
            for w in 0..W {
                y[w] = a[w].fma(b[w], y[w]);
            }
        }
        y
    }

    #[inline(always)]
    fn forward_sum(&self, x: Run, len: usize) -> Block<L, W> {
        let mut y = [L::zero(); W];
        for j in 0..len {
            let x = self.get(x.at(j));
            for w in 0..W {
                y[w] += x[w];
            }
        }
        y
    }

    /// Pulls the cotangents of the results back to the arguments, and sets the cotangents of all operations to zero.
    #[inline(always)]
    pub(super) fn reverse(&mut self) {
        let mut place = self.plan.steps.len();
        while place > self.inputs {
            place -= 1;
            let op = match &self.plan.steps[place] {
                Step::Single(op) => op,
                Step::Layer(number) => {
                    let of = (self.plan.layers[*number], *number);
                    self.memory.reverse_layer(of, self.shared, self.inputs);
                    continue;
                }
                Step::Nothing => continue,
            };
            let bar = self.memory.bars[place];
            if is_zero(bar) {
                continue;
            }
            self.memory.bars[place] = [L::zero(); W];
            match *op {
                // Arguments have no partials, so `partials` keeps the cotangent here until it is taken.
                Op::Input(_) => self.memory.partials[place] = bar,
                Op::Constant(_) | Op::Always(_) | Op::Logic(..) => {}
                // Passes no cotangent on. Multiplying the cotangent by zero could pass NaN on, if the cotangent is
                // infinite.
                Op::Unary(Unary::Detach, _) => {}
                Op::Unary(_, x) => self.add(x, chain(self.memory.partials[place], bar)),
                Op::Binary(Binary::StraightThrough, [_, soft]) => self.add(soft, bar),
                Op::Binary(f, of) => {
                    let x = [self.get(of[0]), self.get(of[1])];
                    let parts = reverse_binary(f, x, bar, &mut self.memory.rows);
                    self.add_both(of, parts);
                }
                Op::Fma([a, b, c]) => {
                    let parts = [chain(self.get(b), bar), chain(self.get(a), bar)];
                    self.add_both([a, b], parts);
                    self.add(c, bar);
                }
                Op::Select(mask, of) => {
                    let (mask, mut parts) = (self.get(mask), [bar; 2]);
                    for w in 0..W {
                        // Selects instead of multiplying by zero, which could give NaN.
                        parts[0][w] = L::select(holds(mask[w]), bar[w], L::zero());
                        parts[1][w] = L::select(holds(mask[w]), L::zero(), bar[w]);
                    }
                    self.add_both(of, parts);
                }
                Op::Dot(x, len) => {
                    if self.reverse_dot(place, x, len as usize, bar) {
                        place -= 1;
                    }
                }
                Op::Sum(x, len) => {
                    for j in 0..len as usize {
                        self.add(x.at(j), bar);
                    }
                }
            }
        }
    }

    /// Pulls back the dot product at `place`. If the operation before it is a dot product of another shared row with
    /// the same own numbers, as in a matrix-vector product, pulls that operation back too and returns true.
    #[inline(always)]
    fn reverse_dot(
        &mut self,
        place: usize,
        [a, b]: [Run; 2],
        len: usize,
        bar: Block<L, W>,
    ) -> bool {
        if a == b {
            let mut twice = bar;
            for w in 0..W {
                twice[w] += bar[w];
            }
            for j in 0..len {
                let x = a.at(j);
                self.add(x, chain(self.get(x), twice));
            }
            return false;
        }
        if !a.is_row() || !b.is_adjacent() || b.first.is_shared() || has_zero(bar) {
            for j in 0..len {
                let (a, b) = (a.at(j), b.at(j));
                let parts = [chain(self.get(b), bar), chain(self.get(a), bar)];
                self.add_both([a, b], parts);
            }
            return false;
        }
        // Two rows at a time, so that the own numbers and their cotangents are loaded and stored only once.
        if place > 0
            && let Step::Single(Op::Dot([x, y], len_before)) = self.plan.steps[place - 1]
            && (x.is_row(), y) == (true, b)
            && b.at(len).at() < place
        {
            let before = self.memory.bars[place - 1];
            if !has_zero(before) {
                self.memory.bars[place - 1] = [L::zero(); W];
                let len_before = len_before as usize;
                let both = len.min(len_before);
                self.reverse_rows([a, x], b, both, [bar, before]);
                self.reverse_rows([a.from(both)], b.from(both), len - both, [bar]);
                let rest = len_before - both;
                self.reverse_rows([x.from(both)], b.from(both), rest, [before]);
                return true;
            }
        }
        self.reverse_rows([a], b, len, [bar]);
        false
    }

    /// Pulls back `D` dot products of shared rows with the same own numbers `b`. All rows have the length `len`. The
    /// cotangents of the products, `bars`, must not be zero.
    #[inline(always)]
    fn reverse_rows<const D: usize>(
        &mut self,
        a: [Run; D],
        b: Run,
        len: usize,
        bars: [Block<L, W>; D],
    ) {
        if len == 0 {
            return;
        }
        let ReplayBuffers {
            read,
            read_bars,
            values,
            bars: own_bars,
            ..
        } = &mut *self.memory;
        let own = b.first.at()..b.first.at() + len;
        let (own, own_bars) = (&values[own.clone()], &mut own_bars[own]);
        let mut rows = [&read[..0]; D];
        for d in 0..D {
            rows[d] = &read[a[d].first.at()..][..len];
        }
        for j in 0..len {
            let (own, mut own_bar) = (own[j], own_bars[j]);
            for d in 0..D {
                let (factor, place) = (L::splat(rows[d][j]), a[d].first.at() + j);
                let mut shared_bar = read_bars[place];
                for w in 0..W {
                    shared_bar = bars[d][w].fma(own[w], shared_bar);
                    own_bar[w] = bars[d][w].fma(factor, own_bar[w]);
                }
                read_bars[place] = shared_bar;
            }
            own_bars[j] = own_bar;
        }
    }
}
