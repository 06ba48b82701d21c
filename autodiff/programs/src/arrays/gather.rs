//! Selects elements of an array by fixed indices.

use autodiff::Real;
use autodiff::simd::Lane;

use super::array::Array;
use super::operation::LaneOperation;
use super::row::{Bars, StepValues};

/// Implements [`Program::gather`](crate::Program::gather).
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
pub struct Gather {
    pub input: Array,
    moves: Moves,
    pub output: Array,
    active: bool,
}

/// The copies that a gather makes. Positions and lengths count the numbers of all starts.
struct Moves {
    /// Copies of adjacent elements to adjacent elements.
    runs: Vec<CopyRun>,
    /// Copies of a single element to several adjacent elements. `len` counts all copies.
    spreads: Vec<CopyRun>,
    /// The number of starts, whose numbers are interleaved.
    starts: usize,
}

/// A copy of `len` numbers from the position `from` in the input to the position `to` in the output.
struct CopyRun {
    from: usize,
    to: usize,
    len: usize,
}

impl Moves {
    fn new(indices: &[Option<usize>], starts: usize) -> Self {
        let (mut runs, mut spreads) = (Vec::new(), Vec::new());
        let mut to = 0;
        while let Some(index) = indices.get(to) {
            let Some(from) = *index else {
                to += 1;
                continue;
            };
            let along = |by: usize| {
                let places = indices[to..].iter().enumerate();
                places
                    .take_while(|(k, i)| **i == Some(from + k * by))
                    .count()
            };
            // A run begins here: either copies of one element, or consecutive elements. Take the longer of the two.
            let (same, rising) = (along(0), along(1));
            let (moves, len) = if same > rising {
                (&mut spreads, same)
            } else {
                (&mut runs, rising)
            };
            let [from, place, numbers] = [from, to, len].map(|n| n * starts);
            moves.push(CopyRun {
                from,
                to: place,
                len: numbers,
            });
            to += len;
        }
        Self {
            runs,
            spreads,
            starts,
        }
    }
}

impl Gather {
    /// For each element of the output, the index of the element of the input that it is a copy of; `None` for zeros. For
    /// a program with one start.
    pub fn indices(&self) -> Vec<Option<usize>> {
        let mut indices = vec![None; self.output.len];
        for CopyRun { from, to, len } in &self.moves.runs {
            (0..*len).for_each(|k| indices[to + k] = Some(from + k));
        }
        for CopyRun { from, to, len } in &self.moves.spreads {
            indices[*to..to + len].fill(Some(*from));
        }
        indices
    }

    pub(crate) fn new(input: Array, indices: &[Option<usize>], output: Array) -> Self {
        Self {
            input,
            moves: Moves::new(indices, input.starts),
            output,
            active: true,
        }
    }
}

/// If an element has several copies, its cotangent is the sum of the cotangents of the copies. This is the number of
/// partial sums of that sum. Partial sums are independent, so their additions need not wait for each other.
const SUMS: usize = 4;

impl<R: Real> LaneOperation<R> for Gather {
    fn outputs(&self) -> Vec<Array> {
        vec![self.output]
    }
    fn set_active(&mut self, arrays: &[bool]) -> bool {
        self.active = arrays[self.input.id];
        self.active
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        let (values, output) = StepValues::and_outputs(parameters, row, &[self.output]);
        let given = values.get(self.input);
        output.fill(R::zero());
        for &CopyRun { from, to, len } in &self.moves.runs {
            for i in (0..len).step_by(L::N) {
                let value = L::load_up_to(&given[from + i..from + len]);
                value.store_up_to(&mut output[to + i..to + len]);
            }
        }
        let starts = self.moves.starts;
        for &CopyRun { from, to, len } in &self.moves.spreads {
            // With one start, the loop below would only use one lane of each register.
            if starts == 1 {
                output[to..to + len].fill(given[from]);
                continue;
            }
            for i in (0..starts).step_by(L::N) {
                let value = L::load_up_to(&given[from + i..from + starts]);
                for place in (to..to + len).step_by(starts) {
                    value.store_up_to(&mut output[place + i..place + starts]);
                }
            }
        }
    }
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, _values: StepValues<R>, bars: &mut Bars<R>) {
        if !self.active {
            return;
        }
        let (mut before, output) = bars.and_outputs(&[self.output]);
        let given = before.get_mut(self.input);
        for &CopyRun { from, to, len } in &self.moves.runs {
            for i in (0..len).step_by(L::N) {
                let bar = L::load_up_to(&output[to + i..to + len]);
                let place = &mut given[from + i..from + len];
                (L::load_up_to(place) + bar).store_up_to(place);
            }
        }
        let starts = self.moves.starts;
        for &CopyRun { from, to, len } in &self.moves.spreads {
            let bars = &output[to..to + len];
            if starts == 1 {
                let mut sums = [R::zero(); SUMS];
                for bars in bars.chunks(SUMS) {
                    for k in 0..bars.len() {
                        sums[k] += bars[k];
                    }
                }
                given[from] += (sums[0] + sums[1]) + (sums[2] + sums[3]);
                continue;
            }
            // The additions have the order of the loop above, so each start gives the same bits as when it runs alone.
            for i in (0..starts).step_by(L::N) {
                let mut sums = [L::splat(R::zero()); SUMS];
                for (k, bars) in bars.chunks_exact(starts).enumerate() {
                    sums[k % SUMS] += L::load_up_to(&bars[i..]);
                }
                let place = &mut given[from + i..from + starts];
                let sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
                (L::load_up_to(place) + sum).store_up_to(place);
            }
        }
    }
}
