//! The record of a computation, and the reverse sweep over it.

use super::current::{self, CONSTANT};
use super::fused::FusedEntry;
use super::var::Var;
use crate::real::Real;

/// In `Entry::parents`: no parent.
pub(super) const NONE: u32 = u32::MAX;
/// In `Entry::parents[0]`: an entry of many parents; `parents[1]` is an index into `Many::linear`.
const LINEAR: u32 = u32::MAX - 1;
/// In `Entry::parents[0]`: a choice by lanes; `parents[1]` is an index into `Many::selects`.
const SELECT: u32 = u32::MAX - 2;
/// In `Entry::parents[0]`: the first output of `Many::fused[parents[1]]`. The least of these marks:
/// every index of a parent is below it.
const FUSED: u32 = u32::MAX - 3;

/// One recorded operation of at most two variables: 24 bytes for f64.
#[derive(Clone, Copy)]
pub(super) struct Entry<R> {
    pub(super) partials: [R; 2],
    pub(super) parents: [u32; 2],
}

/// All that a recording holds.
pub(super) struct Arena<R: Real> {
    pub(super) entries: Vec<Entry<R>>,
    many: Many<R>,
}

/// What does not fit into an entry.
struct Many<R: Real> {
    /// The terms `(partial, parent)` of all linear entries, one entry after the other …
    terms: Vec<(R, u32)>,
    /// … and where each entry's terms begin.
    linear: Vec<usize>,
    /// Masks, and the parents that pass where they hold and where they do not.
    selects: Vec<(R::Mask, [u32; 2])>,
    fused: Vec<FusedEntry<R>>,
}

impl<R: Real> Arena<R> {
    /// Forgets everything and makes room for inputs, which come first.
    fn restart(&mut self, inputs: usize) {
        let entry = Entry {
            partials: [R::zero(), R::zero()],
            parents: [NONE, NONE],
        };
        if self.entries.capacity() == 0 {
            // A vector that starts out small would be moved several times by a short recording.
            self.entries.reserve(2 * inputs + 32);
        }
        // The entry of an input only takes up an index and is never read: old ones may stay.
        self.entries.truncate(inputs);
        self.entries.resize(index(inputs) as usize, entry);
        self.many.terms.clear();
        self.many.linear.clear();
        self.many.selects.clear();
        self.many.fused.clear();
    }

    /// How many entries fit into the memory there is, and into the indices that variables have.
    pub(super) fn room(&self) -> u32 {
        self.entries.capacity().min(FUSED as usize) as u32
    }

    /// Makes room for one more entry at least.
    pub(super) fn make_room(&mut self) {
        index(self.entries.len());
        self.entries.reserve(1);
    }

    /// Appends an entry and returns its index.
    fn push(&mut self, entry: Entry<R>) -> u32 {
        let index = index(self.entries.len());
        self.entries.push(entry);
        index
    }

    /// Appends an entry with any number of terms `(partial, parent)`.
    pub(super) fn push_linear(&mut self, terms: impl Iterator<Item = (R, u32)>, zero: R) -> u32 {
        let entry = index(self.many.linear.len());
        self.many.linear.push(self.many.terms.len());
        self.many.terms.extend(terms);
        self.push(Entry {
            partials: [zero, zero],
            parents: [LINEAR, entry],
        })
    }

    /// Appends a choice of one or the other parent in every lane. Not as partials of 0 and 1: an
    /// infinite cotangent times 0 would be NaN in the lanes where it must not pass.
    pub(super) fn push_select(&mut self, mask: R::Mask, parents: [u32; 2], zero: R) -> u32 {
        let select = index(self.many.selects.len());
        self.many.selects.push((mask, parents));
        self.push(Entry {
            partials: [zero, zero],
            parents: [SELECT, select],
        })
    }

    /// Appends a fused entry and one entry for each of its outputs; returns the first's index.
    pub(super) fn push_fused(&mut self, fused: FusedEntry<R>, zero: R) -> u32 {
        let (first, outputs) = (index(self.many.fused.len()), fused.outputs);
        self.many.fused.push(fused);
        let entry = |parents| Entry {
            partials: [zero, zero],
            parents,
        };
        let first = self.push(entry([FUSED, first]));
        for _ in 1..outputs {
            self.push(entry([NONE, NONE]));
        }
        first
    }

    /// Carries the cotangents of all entries back to the inputs, which come first.
    ///
    /// The parent of an entry is often the one before it. The cotangent of that one is kept in a
    /// register: a store to `bars` and a load in the next turn would cost the latency of both.
    fn sweep(&mut self, bars: &mut [R], inputs: usize) {
        // Slices of one length, not vectors behind `self`: nothing is loaded again in the loop.
        let (entries, many) = (self.entries.as_slice(), &mut self.many);
        let bars = &mut bars[..entries.len()];
        let Some(&(mut bar)) = bars.last() else {
            return;
        };
        // Without inputs nothing is recorded. From 1 on `i - 1` exists, which saves bounds checks.
        let inputs = inputs.max(1);
        for i in (inputs..entries.len()).rev() {
            let Entry { partials, parents } = entries[i];
            let before = i - 1;
            if parents[0] >= FUSED {
                bars[i] = bar;
                many.sweep(parents, i, bars);
                bar = bars[before];
                continue;
            }
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

impl<R: Real> Many<R> {
    /// The sweep over the entry at place `i`, which has many parents or outputs, or no parents.
    #[inline(never)]
    fn sweep(&mut self, [kind, place]: [u32; 2], i: usize, bars: &mut [R]) {
        let place = place as usize;
        match kind {
            // The outputs' entries follow this one: their cotangents are complete by now.
            FUSED => self.fused[place].reverse(i, bars),
            LINEAR if !bars[i].is_zero() => {
                let bar = bars[i];
                let end = self.linear.get(place + 1).copied();
                let terms = self.linear[place]..end.unwrap_or(self.terms.len());
                for &(partial, parent) in &self.terms[terms] {
                    let parent = &mut bars[parent as usize];
                    *parent = R::chain_add(partial, bar, *parent);
                }
            }
            SELECT => {
                let ((mask, parents), bar, zero) = (self.selects[place], bars[i], R::zero());
                let parts = [R::select(mask, bar, zero), R::select(mask, zero, bar)];
                for (parent, part) in parents.into_iter().zip(parts) {
                    if parent != NONE {
                        bars[parent as usize] += part;
                    }
                }
            }
            _ => {}
        }
    }
}

/// A place in an arena, in the 32 bits that a variable has for it.
fn index(place: usize) -> u32 {
    if place >= FUSED as usize {
        full();
    }
    place as u32
}

#[cold]
fn full() -> ! {
    panic!(
        "the tape is full: one recording holds at most {FUSED} entries; \
         record shorter pieces and join them, as a rollout does"
    )
}

/// A record of one computation at a time, to be swept in reverse.
///
/// A tape is an ordinary value: keep it and record again to reuse its memory, send it to another
/// thread, nest it (`Tape<Dual<f64, 1>>`, `Tape<Var<f64>>`). It is current, that is, its
/// variables can be computed with, only inside the closure of [`record`](Tape::record).
///
/// An operation takes 24 bytes in f64 and 8 more in a reverse sweep; none of it is freed before the
/// tape is dropped. Where the system has no more memory the process ends, as with any collection: for
/// long loops take a [`Rollout`](crate::Rollout), which keeps to a budget.
///
/// ```
/// use autodiff::{Real, Tape};
///
/// let mut tape = Tape::new();
/// let y = tape.record(&[3.0, 4.0], |x| x[0].hypot(x[1]));
/// assert_eq!(y.value(), 5.0);
/// assert_eq!(tape.pullback(&[y], &[1.0]), [0.6, 0.8]);
/// ```
///
/// A variable that was kept from an earlier recording is refused, wherever it is used:
///
/// ```should_panic
/// use autodiff::Tape;
///
/// let mut tape = Tape::new();
/// let old = tape.record(&[3.0], |x| x[0] * x[0]);
/// tape.record(&[4.0], |x| x[0] + old);
/// ```
pub struct Tape<R: Real> {
    arena: Arena<R>,
    /// The name of `R` within generations, see [`current::name_of`].
    name: u32,
    generation: u32,
    inputs: Vec<Var<R>>,
    bars: Vec<R>,
}

impl<R: Real> Tape<R> {
    /// An empty tape.
    pub fn new() -> Self {
        let arena = Arena {
            entries: Vec::new(),
            many: Many {
                terms: Vec::new(),
                linear: Vec::new(),
                selects: Vec::new(),
                fused: Vec::new(),
            },
        };
        Tape {
            arena,
            name: current::name_of::<R>(),
            generation: CONSTANT,
            inputs: Vec::new(),
            bars: Vec::new(),
        }
    }

    /// Forgets the last recording, keeps its memory, and records `function` of `inputs`.
    ///
    /// The variables that `function` returns serve [`pullback`](Tape::pullback) until the next
    /// recording, and nothing else.
    pub fn record<T>(&mut self, inputs: &[R], function: impl FnOnce(&[Var<R>]) -> T) -> T {
        self.arena.restart(inputs.len());
        self.generation = current::next_generation(self.name);
        let generation = self.generation;
        let mut variables = std::mem::take(&mut self.inputs);
        variables.clear();
        variables.extend((0..).zip(inputs).map(|(index, &value)| Var {
            value,
            index,
            generation,
        }));
        let result = current::enter(&mut self.arena, generation, || function(&variables));
        self.inputs = variables;
        result
    }

    /// The cotangents of the inputs, given those of the outputs: `sum_i cotangents_i d outputs_i
    /// / d inputs` (a VJP). May be called any number of times after one recording.
    ///
    /// # Panics
    /// If an output belongs to another recording, or the lengths differ.
    pub fn pullback(&mut self, outputs: &[Var<R>], cotangents: &[R]) -> &[R] {
        assert_eq!(
            outputs.len(),
            cotangents.len(),
            "pullback needs one cotangent per output"
        );
        self.bars.clear();
        self.bars.resize(self.arena.entries.len(), R::zero());
        for (output, &cotangent) in outputs.iter().zip(cotangents) {
            if output.is_constant() {
                continue;
            }
            assert!(
                output.generation == self.generation,
                "pullback was given a variable of another recording, an earlier one of this tape \
                 or another tape's; it takes those that the last `record` of this tape returned"
            );
            self.bars[output.index as usize] += cotangent;
        }
        self.arena.sweep(&mut self.bars, self.inputs.len());
        &self.bars[..self.inputs.len()]
    }

    /// How many entries the last recording made, including one for each input.
    pub fn len(&self) -> usize {
        self.arena.entries.len()
    }

    /// Forgets the last recording and keeps its memory.
    pub(super) fn forget(&mut self) {
        self.arena.restart(0);
    }

    /// The bytes that it has allocated, but for selects and fused entries, which are rare.
    pub(super) fn bytes(&self) -> usize {
        let entries = self.arena.entries.capacity() * size_of::<Entry<R>>();
        let terms = self.arena.many.terms.capacity() * size_of::<(R, u32)>();
        entries + terms + self.bars.capacity() * size_of::<R>()
    }

    /// Whether nothing is recorded.
    pub fn is_empty(&self) -> bool {
        self.arena.entries.is_empty()
    }
}

impl<R: Real> Default for Tape<R> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entry_is_24_bytes() {
        assert_eq!(size_of::<Entry<f64>>(), 24);
    }

    #[test]
    #[should_panic(expected = "the tape is full")]
    fn a_full_arena_says_so() {
        index(FUSED as usize);
    }
}
