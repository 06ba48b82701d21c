//! The entries of a recording, and the reverse sweep over them.

use super::careful::Careful;
use super::entries::{Entry, LongEntries, Term, allocated};
use super::fused_entry::FusedEntry;
use super::index::{FUSED, LINEAR, NONE, SELECT, STOPPED, index};
use crate::real::{Mask, Real};
use crate::rule::vanishes;

/// The contents of a recording.
pub(super) struct Arena<R: Real> {
    pub(super) entries: Vec<Entry<R>>,
    long: LongEntries<R>,
}

impl<R: Real> Arena<R> {
    /// An empty recording.
    pub(super) fn new() -> Self {
        Arena {
            entries: Vec::new(),
            long: LongEntries::new(),
        }
    }

    /// Clears the recording and makes room for inputs, which come first.
    pub(super) fn restart(&mut self, inputs: usize) {
        let entry = Entry {
            partials: [R::zero(), R::zero()],
            parents: [NONE, NONE],
        };
        if self.entries.capacity() == 0 {
            // A vector that starts small would be moved several times by a short recording.
            self.entries.reserve(2 * inputs + 32);
        }
        // The entry of an input only takes up an index and is never read, so old entries may stay.
        self.entries.truncate(inputs);
        self.entries.resize(index(inputs) as usize, entry);
        self.long.clear();
    }

    /// The number of bytes allocated, without the memory that fused entries own. There are no fused entries after a
    /// [restart](Self::restart).
    pub(super) fn bytes(&self) -> usize {
        allocated(&self.entries) + self.long.bytes()
    }

    /// The number of entries that fit into the allocated memory and into the indices of variables.
    pub(super) fn room(&self) -> u32 {
        self.entries.capacity().min(FUSED as usize) as u32
    }

    /// Makes room for at least one more entry.
    pub(super) fn make_room(&mut self) {
        index(self.entries.len());
        self.entries.reserve(1);
    }

    /// Appends an entry that refers to [`LongEntries`] and returns its index.
    fn push_mark(&mut self, parents: [u32; 2], zero: R) -> u32 {
        let index = index(self.entries.len());
        let partials = [zero, zero];
        self.entries.push(Entry { partials, parents });
        index
    }

    /// Appends an entry with any number of terms.
    pub(super) fn push_linear(&mut self, terms: impl Iterator<Item = Term<R>>, zero: R) -> u32 {
        let LongEntries {
            linear,
            terms: all,
            stopped,
            ..
        } = &mut self.long;
        let entry = index(linear.len());
        linear.push(all.len());
        for term in terms {
            if term.stops {
                stopped.push((entry, term.parent));
            } else {
                all.push((term.partial, term.parent));
            }
        }
        self.push_mark([LINEAR, entry], zero)
    }

    /// Appends a choice between two parents in every lane. It does not use partials of 0 and 1, because an infinite
    /// cotangent times 0 would be NaN in lanes where it must not pass.
    pub(super) fn push_select(&mut self, mask: R::Mask, parents: [u32; 2], zero: R) -> u32 {
        let select = index(self.long.selects.len());
        self.long.selects.push((mask, parents));
        self.push_mark([SELECT, select], zero)
    }

    /// Appends a fused entry and one entry for each of its outputs. Returns the index of the first output.
    pub(super) fn push_fused(&mut self, fused: FusedEntry<R>, zero: R) -> u32 {
        let (first, outputs) = (index(self.long.fused.len()), fused.outputs);
        self.long.fused.push(fused);
        let first = self.push_mark([FUSED, first], zero);
        for _ in 1..outputs {
            self.push_mark([NONE, NONE], zero);
        }
        first
    }

    /// Calls `visit` with each parent of the entry at place `at`, which has many parents or outputs. Every output
    /// of a fused function counts as depending on all inputs.
    pub(super) fn each_parent_of_long(&self, at: usize, mut visit: impl FnMut(u32)) {
        let LongEntries {
            stopped,
            selects,
            fused,
            ..
        } = &self.long;
        let marked = |at: &usize| self.entries[*at].parents != [NONE, NONE];
        // The later outputs of a fused function follow the entry that has its mark.
        let Some([kind, place]) = (0..=at)
            .rev()
            .find(marked)
            .map(|at| self.entries[at].parents)
        else {
            return;
        };
        match kind {
            FUSED => {
                let fused = &fused[place as usize];
                let slices = fused.parents.iter().zip(&fused.lengths);
                slices.for_each(|(parents, &len)| parents.each(len, &mut visit));
            }
            LINEAR => {
                let terms = self.long.terms_of(place).iter();
                terms.for_each(|&(_, parent)| visit(parent));
                let first = stopped.partition_point(|&(entry, _)| entry < place);
                let here = stopped[first..]
                    .iter()
                    .take_while(|(entry, _)| *entry == place);
                here.for_each(|&(_, parent)| visit(parent));
            }
            SELECT => selects[place as usize].1.into_iter().for_each(visit),
            STOPPED => visit(place),
            _ => {}
        }
    }

    /// Pulls the cotangents of all entries back to the inputs, which come first.
    ///
    /// The parent of an entry is often the entry before it. The cotangent of that entry stays in a register,
    /// because a store to `bars` and a load in the next turn would cost the latency of both.
    pub(super) fn sweep(&mut self, bars: &mut [R], inputs: usize) {
        // Slices of one length, so that the loop does not load vectors behind `self` again.
        let (entries, long) = (self.entries.as_slice(), &mut self.long);
        let bars = &mut bars[..entries.len()];
        let Some(&(mut bar)) = bars.last() else {
            return;
        };
        // Without inputs nothing is recorded. With `i >= 1` the entry `i - 1` exists, which saves bounds checks.
        let inputs = inputs.max(1);
        for i in (inputs..entries.len()).rev() {
            let Entry { partials, parents } = entries[i];
            let before = i - 1;
            // Marks are larger than every index, so one comparison finds the rare entries.
            if parents[0] >= FUSED {
                bars[i] = bar;
                if long.is_doubtful(parents, bar) {
                    return Careful::sweep(entries, long, bars, inputs..i + 1);
                }
                long.sweep(parents, i, bars);
                bar = bars[before];
                continue;
            }
            if vanishes(bar) && !(partials[0].finite() & partials[1].finite()).all() {
                bars[i] = bar;
                return Careful::sweep(entries, long, bars, inputs..i + 1);
            }
            // A zero cotangent adds nothing through finite partials. Entries that no result depends on have one.
            let mut bar_before = bars[before];
            if !bar.is_zero() {
                let mut give = |parent: u32, partial| {
                    let parent = parent as usize;
                    if parent == before {
                        bar_before = R::chain_add(partial, bar, bar_before);
                    } else {
                        bars[parent] = R::chain_add(partial, bar, bars[parent]);
                    }
                };
                give(parents[0], partials[0]);
                if parents[1] != NONE {
                    give(parents[1], partials[1]);
                }
            }
            bar = bar_before;
        }
        bars[inputs - 1] = bar;
    }
}
