//! Sums the numbers of edges at both of their ends.

use autodiff::Real;
use autodiff::simd::Lane;

use super::array::Array;
use super::graph::{Graph, SlotEdge};
use super::operation::LaneOperation;
use super::row::{Bars, StepValues};

/// Implements [`Program::sum_at_nodes`](crate::Program::sum_at_nodes).
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
pub struct NodeSum {
    pub edges: Vec<SlotEdge>,
    pub input: Array,
    pub output: Array,
    is_active: bool,
}

impl NodeSum {
    pub(crate) fn new(graph: &Graph, input: Array, output: Array) -> Self {
        Self {
            edges: graph.edges_by_slot(),
            input,
            output,
            is_active: true,
        }
    }
}

impl<R: Real> LaneOperation<R> for NodeSum {
    fn outputs(&self) -> Vec<Array> {
        vec![self.output]
    }
    fn set_active(&mut self, arrays: &[bool]) -> bool {
        self.is_active = arrays[self.input.id];
        self.is_active
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        let (values, output) = StepValues::and_outputs(parameters, row, &[self.output]);
        let (given, starts) = (values.get(self.input), self.input.starts);
        output.fill(R::zero());
        for edge in &self.edges {
            for s in 0..starts {
                let number = given[edge.slot * starts + s];
                output[edge.tail * starts + s] += number;
                output[edge.head * starts + s] += number;
            }
        }
    }
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, _values: StepValues<R>, bars: &mut Bars<R>) {
        if !self.is_active {
            return;
        }
        let (mut before, output) = bars.and_outputs(&[self.output]);
        let (given, starts) = (before.get_mut(self.input), self.input.starts);
        for edge in &self.edges {
            for s in 0..starts {
                let ends = output[edge.tail * starts + s] + output[edge.head * starts + s];
                given[edge.slot * starts + s] += ends;
            }
        }
    }
}
