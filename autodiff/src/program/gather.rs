//! Picking entries of an array by fixed indices.

use super::{Array, Operation};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

pub(super) struct Gather {
    input: Array,
    /// Entries that lie side by side in input and output are moved together.
    runs: Vec<Run>,
    output: Array,
    active: bool,
}

/// `len` entries, from and to places in the arena.
struct Run {
    from: usize,
    to: usize,
    len: usize,
}

impl Gather {
    pub(super) fn new(input: Array, indices: &[Option<usize>], output: Array) -> Self {
        let mut runs: Vec<Run> = Vec::new();
        for (to, index) in indices.iter().enumerate() {
            let Some(from) = index.map(|index| input.start + index) else {
                continue;
            };
            let to = output.start + to;
            match runs.last_mut() {
                Some(run) if run.from + run.len == from && run.to + run.len == to => run.len += 1,
                _ => runs.push(Run { from, to, len: 1 }),
            }
        }
        Self {
            input,
            runs,
            output,
            active: true,
        }
    }
}

impl<R: Real> Operation<R> for Gather {
    fn inputs(&self) -> Vec<Array> {
        vec![self.input]
    }
    fn outputs(&self) -> Vec<Array> {
        vec![self.output]
    }
    fn reverse_reads(&self) -> Vec<Array> {
        Vec::new()
    }
    /// Places without an index keep the zero that the arena began with.
    fn forward(&mut self, values: &mut [R]) {
        R::vectorize(Move {
            runs: &self.runs,
            arena: values,
            back: false,
        });
    }
    fn reverse(&mut self, _values: &[R], bars: &mut [R]) {
        if self.active {
            R::vectorize(Move {
                runs: &self.runs,
                arena: bars,
                back: true,
            });
        }
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.active = arrays[self.input.id];
    }
}

/// Moves runs from input to output, or adds them back.
struct Move<'a, R> {
    runs: &'a [Run],
    arena: &'a mut [R],
    back: bool,
}

impl<R: Real> Vectorized<R> for Move<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        for &Run { from, to, len } in self.runs {
            for i in (0..len).step_by(L::N) {
                if self.back {
                    let bar = L::load_up_to(&self.arena[to + i..to + len]);
                    let place = &mut self.arena[from + i..from + len];
                    (L::load_up_to(place) + bar).store_up_to(place);
                } else {
                    let value = L::load_up_to(&self.arena[from + i..from + len]);
                    value.store_up_to(&mut self.arena[to + i..to + len]);
                }
            }
        }
    }
}
