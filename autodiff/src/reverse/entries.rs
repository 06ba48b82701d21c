//! The entries of a recording, and the operands of operations that have too many operands for an entry.

use super::fused_entry::FusedEntry;
use super::index::{Kind, NONE};
use crate::real::{Mask, Real};
use crate::rule::vanishes;

/// A recorded operation on at most two variables; 24 bytes for f64.
#[derive(Clone, Copy)]
pub(super) struct Entry<R> {
    pub(super) partials: [R; 2],
    pub(super) parents: [u32; 2],
}

const _: () = assert!(size_of::<Entry<f64>>() == 24);

/// The operands of operations that have too many operands for an [`Entry`].
pub(super) struct LongEntries<R: Real> {
    /// The terms `(partial, parent)` of all linear entries (linear combinations), in the order of the entries.
    pub(super) terms: Vec<(R, u32)>,
    /// For each linear entry, the index of its first term.
    pub(super) linear: Vec<usize>,
    /// Pairs of a linear entry (ascending) and one of its parents. The entry passes no derivative to this parent,
    /// because the factor is a constant zero.
    pub(super) stopped: Vec<(u32, u32)>,
    /// For each select: the mask, the parent where it is true, and the parent where it is false.
    pub(super) selects: Vec<(R::Mask, [u32; 2])>,
    pub(super) fused: Vec<FusedEntry<R>>,
}

/// A term of a linear entry: a partial times a parent.
pub(super) struct Term<R> {
    pub(super) partial: R,
    pub(super) parent: u32,
    /// Whether the partial is a constant zero, so that no derivative passes.
    pub(super) stops: bool,
}

/// How many bytes a vector has allocated.
pub(super) fn allocated<T>(vector: &Vec<T>) -> usize {
    vector.capacity() * size_of::<T>()
}

impl<R: Real> LongEntries<R> {
    /// Returns an empty list.
    pub(super) fn new() -> Self {
        Self {
            terms: Vec::new(),
            linear: Vec::new(),
            stopped: Vec::new(),
            selects: Vec::new(),
            fused: Vec::new(),
        }
    }

    /// Removes all operands but keeps the memory.
    pub(super) fn clear(&mut self) {
        self.terms.clear();
        self.linear.clear();
        self.stopped.clear();
        self.selects.clear();
        self.fused.clear();
    }

    /// How many bytes are allocated, not counting the memory that fused entries own.
    pub(super) fn bytes(&self) -> usize {
        allocated(&self.terms)
            + allocated(&self.linear)
            + allocated(&self.stopped)
            + allocated(&self.selects)
            + allocated(&self.fused)
    }

    /// Returns the terms of linear entry `place`.
    pub(super) fn terms_of(&self, place: u32) -> &[(R, u32)] {
        let place = place as usize;
        let end = self.linear.get(place + 1).copied();
        &self.terms[self.linear[place]..end.unwrap_or(self.terms.len())]
    }

    /// Whether a linear entry has a cotangent of zero and a partial that is not finite.
    pub(super) fn is_doubtful(&self, parents: [u32; 2], bar: R) -> bool {
        let Kind::Linear(place) = Kind::of(parents) else {
            return false;
        };
        let finite = |&(partial, _): &(R, u32)| partial.finite().all();
        vanishes(bar) && !self.terms_of(place).iter().all(finite)
    }

    /// Pulls back the cotangent of entry `i`, whose operands are in this struct because it has many parents or outputs,
    /// or no parents.
    #[inline(never)]
    #[track_caller]
    pub(super) fn sweep(&mut self, parents: [u32; 2], i: usize, bars: &mut [R]) {
        match Kind::of(parents) {
            // The entries of the other outputs follow this one, so all cotangents of outputs are complete.
            Kind::FirstOutput(place) => self.fused[place as usize].reverse(i, bars),
            Kind::Linear(place) => {
                let bar = bars[i];
                if bar.is_zero() {
                    return;
                }
                for &(partial, parent) in self.terms_of(place) {
                    let parent = &mut bars[parent as usize];
                    *parent = R::chain_add(partial, bar, *parent);
                }
            }
            Kind::Select(place) => {
                let (mask, parents) = self.selects[place as usize];
                let (bar, zero) = (bars[i], R::zero());
                let parts = [R::select(mask, bar, zero), R::select(mask, zero, bar)];
                for (parent, part) in parents.into_iter().zip(parts) {
                    if parent != NONE {
                        bars[parent as usize] += part;
                    }
                }
            }
            Kind::LaterOutput | Kind::Stopped(_) => {}
            Kind::Short(_) => unreachable!("the arena sweeps short entries"),
        }
    }
}
