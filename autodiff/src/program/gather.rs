//! Picking entries of an array by fixed indices.

use super::{Array, Operation};
use crate::real::Real;

pub(super) struct Gather {
    input: Array,
    /// `(place in the output, place in the input)`, both in the arena.
    moves: Vec<(u32, u32)>,
    output: Array,
    active: bool,
}

impl Gather {
    pub(super) fn new(input: Array, indices: &[Option<usize>], output: Array) -> Self {
        let place = |at: usize| u32::try_from(at).expect("an arena holds less than 2^32 numbers");
        let moves = indices.iter().enumerate();
        let moves = moves.filter_map(|(to, from)| from.map(|from| (to, from)));
        let moves = moves.map(|(to, from)| (place(output.start + to), place(input.start + from)));
        Self {
            input,
            moves: moves.collect(),
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
        for &(to, from) in &self.moves {
            values[to as usize] = values[from as usize];
        }
    }
    fn reverse(&mut self, _values: &[R], bars: &mut [R]) {
        if self.active {
            for &(to, from) in &self.moves {
                let bar = bars[to as usize];
                bars[from as usize] += bar;
            }
        }
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.active = arrays[self.input.id];
    }
}
