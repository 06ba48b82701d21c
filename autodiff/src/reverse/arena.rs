//! The storage of a recording, and the reverse sweep over it.

use super::careful::Careful;
use super::entries::{Entry, LongEntries, Term, allocated};
use super::fused_entry::FusedEntry;
use super::index::{FUSED, Kind, LINEAR, NONE, SELECT, index};
use crate::real::{Mask, Real};
use crate::rule::vanishes;

/// The entries of a recording.
pub(super) struct Arena<R: Real> {
    pub(super) entries: Vec<Entry<R>>,
    long: LongEntries<R>,
}

impl<R: Real> Arena<R> {
    /// Returns an empty recording.
    pub(super) fn new() -> Self {
        Arena {
            entries: Vec::new(),
            long: LongEntries::new(),
        }
    }

    /// Clears the recording and makes room for the inputs, which are the first entries.
    pub(super) fn restart(&mut self, inputs: usize) {
        let entry = Entry {
            partials: [R::zero(), R::zero()],
            parents: [NONE, NONE],
        };
        if self.entries.capacity() == 0 {
            // Without this, a short recording would grow its vector several times.
            self.entries.reserve(2 * inputs + 32);
        }
        // The entries of inputs only reserve indices and are never read, so old entries may stay.
        self.entries.truncate(inputs);
        self.entries.resize(index(inputs) as usize, entry);
        self.long.clear();
    }

    /// How many bytes are allocated, not counting the memory that fused entries own. After a [restart](Self::restart)
    /// there are no fused entries.
    pub(super) fn bytes(&self) -> usize {
        allocated(&self.entries) + self.long.bytes()
    }

    /// How many entries fit into the allocated memory. The number is limited by what 32-bit indices can address.
    pub(super) fn room(&self) -> u32 {
        self.entries.capacity().min(FUSED as usize) as u32
    }

    /// Makes room for at least one more entry.
    pub(super) fn make_room(&mut self) {
        index(self.entries.len());
        self.entries.reserve(1);
    }

    /// Appends an entry whose operands are in [`LongEntries`] and returns its index.
    fn push_mark(&mut self, parents: [u32; 2], zero: R) -> u32 {
        let index = index(self.entries.len());
        let partials = [zero, zero];
        self.entries.push(Entry { partials, parents });
        index
    }

    /// Appends a linear combination of any number of terms and returns its index.
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

    /// Appends a select, lane by lane, between two parents. The entry stores the mask and not partials of 0 and 1: in a
    /// lane that must pass nothing, an infinite cotangent times 0 would be NaN.
    pub(super) fn push_select(&mut self, mask: R::Mask, parents: [u32; 2], zero: R) -> u32 {
        let select = index(self.long.selects.len());
        self.long.selects.push((mask, parents));
        self.push_mark([SELECT, select], zero)
    }

    /// Appends a fused function: one entry for each output. Returns the index of the first output.
    pub(super) fn push_fused(&mut self, fused: FusedEntry<R>, zero: R) -> u32 {
        let (place, first) = (index(self.long.fused.len()), index(self.entries.len()));
        self.long.fused.push(FusedEntry { first, ..fused });
        let outputs = self.long.fused[place as usize].outputs;
        self.push_mark([FUSED, place], zero);
        for _ in 1..outputs {
            self.push_mark([NONE, NONE], zero);
        }
        first
    }

    /// Calls `visit` with each parent of the entry at index `at`; the last may be [`NONE`]. Every output of a fused function
    /// counts as depending on all inputs.
    pub(super) fn each_parent(&self, at: usize, mut visit: impl FnMut(u32)) {
        let LongEntries {
            stopped,
            selects,
            fused,
            ..
        } = &self.long;
        match Kind::of(self.entries[at].parents) {
            Kind::Short(parents) => parents.into_iter().for_each(visit),
            Kind::FirstOutput(_) | Kind::LaterOutput => {
                let later = fused.partition_point(|fused| fused.first as usize <= at);
                let fused = &fused[later - 1];
                let slices = fused.parents.iter().zip(&fused.lengths);
                slices.for_each(|(parents, &len)| parents.each(len, &mut visit));
            }
            Kind::Linear(place) => {
                let terms = self.long.terms_of(place).iter();
                terms.for_each(|&(_, parent)| visit(parent));
                let first = stopped.partition_point(|&(entry, _)| entry < place);
                let here = stopped[first..]
                    .iter()
                    .take_while(|(entry, _)| *entry == place);
                here.for_each(|&(_, parent)| visit(parent));
            }
            Kind::Select(place) => selects[place as usize].1.into_iter().for_each(visit),
            Kind::Stopped(parent) => visit(parent),
        }
    }

    /// Pulls the cotangents of all entries back to the inputs, which are the first entries.
    ///
    /// The parent of an entry is often the entry before it. The cotangent of the entry before stays in a register:
    /// storing it to `bars` and loading it in the next turn would cost the latency of a store and a load.
    #[track_caller]
    pub(super) fn sweep(&mut self, bars: &mut [R], inputs: usize) {
        // As local slices of equal length, these need no bounds checks and no reloads through `self`.
        let (entries, long) = (self.entries.as_slice(), &mut self.long);
        let bars = &mut bars[..entries.len()];
        let Some(&(mut bar)) = bars.last() else {
            return;
        };
        // Without inputs nothing is recorded. Starting at `i >= 1` ensures that the entry `i - 1` exists, which saves
        // bounds checks.
        let inputs = inputs.max(1);
        for i in (inputs..entries.len()).rev() {
            let Entry { partials, parents } = entries[i];
            let before = i - 1;
            // Marks are larger than every index, so one comparison detects the rare entries.
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
            // A zero cotangent adds nothing if the partials are finite. Entries on which no result depends have a zero
            // cotangent.
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
