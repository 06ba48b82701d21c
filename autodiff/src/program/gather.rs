//! Picking entries of an array by fixed indices.

use super::row::Frame;
use super::{Array, Bars, Operation};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

pub(super) struct Gather {
    input: Array,
    /// Entries that lie side by side in input and output are moved together.
    runs: Vec<Run>,
    output: Array,
    active: bool,
}

/// `len` entries, from places of the input to places of the output.
struct Run {
    from: usize,
    to: usize,
    len: usize,
}

impl Gather {
    pub(super) fn new(input: Array, indices: &[Option<usize>], output: Array) -> Self {
        let mut runs: Vec<Run> = Vec::new();
        for (to, index) in indices.iter().enumerate() {
            let &Some(from) = index else { continue };
            match runs.last_mut() {
                Some(run) if run.from + run.len == from && run.to + run.len == to => run.len += 1,
                _ => runs.push(Run { from, to, len: 1 }),
            }
        }
        for Run { from, to, len } in &mut runs {
            [*from, *to, *len] = [*from, *to, *len].map(|n| n * input.starts);
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
    fn outputs(&self) -> Vec<Array> {
        vec![self.output]
    }
    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        let (row, output) = row.split_at_mut(self.output.start);
        let output = &mut output[..self.output.len];
        output.fill(R::zero());
        R::vectorize(Forward {
            runs: &self.runs,
            from: Frame { parameters, row }.get(self.input),
            to: output,
        });
    }
    fn reverse(&mut self, _values: &Frame<R>, bars: &mut Bars<R>) {
        if !self.active {
            return;
        }
        let Bars { parameters, row } = bars;
        let (row, output) = row.split_at_mut(self.output.start);
        let mut before = Bars { parameters, row };
        R::vectorize(Reverse {
            runs: &self.runs,
            from: &output[..self.output.len],
            to: before.get_mut(self.input),
        });
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.active = arrays[self.input.id];
    }
}

/// Moves runs from input to output.
struct Forward<'a, R> {
    runs: &'a [Run],
    from: &'a [R],
    to: &'a mut [R],
}

impl<R: Real> Vectorized<R> for Forward<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        for &Run { from, to, len } in self.runs {
            for i in (0..len).step_by(L::N) {
                let value = L::load_up_to(&self.from[from + i..from + len]);
                value.store_up_to(&mut self.to[to + i..to + len]);
            }
        }
    }
}

/// Adds the cotangents of the output to those of the input.
struct Reverse<'a, R> {
    runs: &'a [Run],
    from: &'a [R],
    to: &'a mut [R],
}

impl<R: Real> Vectorized<R> for Reverse<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        for &Run { from, to, len } in self.runs {
            for i in (0..len).step_by(L::N) {
                let bar = L::load_up_to(&self.from[to + i..to + len]);
                let place = &mut self.to[from + i..from + len];
                (L::load_up_to(place) + bar).store_up_to(place);
            }
        }
    }
}
