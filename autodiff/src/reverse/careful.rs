//! Continues a reverse sweep from the first zero cotangent that meets an infinite partial.
//!
//! Such a zero has one of two causes. If no result depends on the entry, the zero comes from a choice (such as a select
//! that did not choose the entry), and the entry passes nothing on. If a result depends on the entry, the zero was
//! computed. Its product with infinity is unknown, so it becomes NaN. If a later partial in the sweep is exactly zero,
//! it stops the NaN, like it stops a tangent in forward mode. For example, the derivative of `sqrt(x * x)^2` at 0 is 0,
//! but the derivative of `1 / (1 / x)` is NaN.

use std::ops::Range;

use super::entries::{Entry, LongEntries};
use super::index::{Kind, NONE};
use crate::real::{Mask, Real};
use crate::rule::vanishes;

pub(super) struct Careful<'a, R> {
    bars: &'a mut [R],
    /// For each entry, NaN if its cotangent is unknown, otherwise zero.
    unknown: Vec<R>,
    /// For each entry, whether a result depends on it. An entry that a choice did not select does not count.
    reached: Vec<bool>,
}

impl<'a, R: Real> Careful<'a, R> {
    /// Sweeps back over the entries in `range`. Before the call, `bars` must hold complete cotangents: of the last
    /// entry in the range, and of each later entry that has several parents or outputs.
    #[cold]
    #[inline(never)]
    pub(super) fn sweep(
        entries: &[Entry<R>],
        long: &mut LongEntries<R>,
        bars: &'a mut [R],
        range: Range<usize>,
    ) {
        let mut sweep = Self {
            unknown: vec![R::zero(); range.end],
            reached: vec![false; entries.len()],
            bars,
        };
        for i in (range.end..entries.len()).rev() {
            if sweep.is_reached(i) {
                let reached = &mut sweep.reached;
                each_partial(entries[i], long, |_, parent| reached[parent] = true);
            }
        }
        for i in range.clone().rev() {
            if let Kind::FirstOutput(place) = Kind::of(entries[i].parents) {
                sweep.reverse_fused(i, place, long);
            } else if sweep.is_reached(i) || !sweep.unknown[i].is_zero() {
                each_partial(entries[i], long, |partial, parent| {
                    sweep.give(i, partial, parent);
                });
            }
        }
        for (bar, &unknown) in sweep.bars[..range.start].iter_mut().zip(&sweep.unknown) {
            *bar += unknown;
        }
    }

    /// Whether a result depends on entry `i`. A nonzero cotangent also counts, because seeds and cotangents from fused
    /// functions appear only there.
    fn is_reached(&mut self, i: usize) -> bool {
        self.reached[i] |= !self.bars[i].is_zero();
        self.reached[i]
    }

    fn give(&mut self, i: usize, partial: R, parent: usize) {
        let (bar, unknown) = (self.bars[i], self.unknown[i]);
        if self.reached[i] {
            self.reached[parent] = true;
            if vanishes(bar) && !partial.finite().all() {
                self.unknown[parent] += partial * bar;
            } else {
                self.bars[parent] = R::chain_add(partial, bar, self.bars[parent]);
            }
        }
        // The partial acts like a tangent here: a zero stops the NaN.
        if !unknown.is_zero() {
            self.unknown[parent] += R::chain(unknown, partial);
        }
    }

    /// Zeros that a fused function returns count as choices, so they pass nothing on.
    fn reverse_fused(&mut self, i: usize, place: u32, long: &mut LongEntries<R>) {
        let fused = &mut long.fused[place as usize];
        let outputs = i..self.unknown.len().min(i + fused.outputs);
        for output in outputs {
            self.bars[output] += self.unknown[output];
        }
        fused.reverse(i, self.bars);
    }
}

/// Calls `visit` with each partial of an entry and the index of its parent. Outputs of fused functions have none.
fn each_partial<R: Real>(entry: Entry<R>, long: &LongEntries<R>, mut visit: impl FnMut(R, usize)) {
    match Kind::of(entry.parents) {
        Kind::Linear(place) => {
            let terms = long.terms_of(place).iter();
            terms.for_each(|&(partial, parent)| visit(partial, parent as usize));
        }
        Kind::Short([first, second]) => {
            visit(entry.partials[0], first as usize);
            if second != NONE {
                visit(entry.partials[1], second as usize);
            }
        }
        // It is never recorded for number types that get here.
        Kind::Select(_) => {}
        Kind::Stopped(_) | Kind::FirstOutput(_) | Kind::LaterOutput => {}
    }
}
