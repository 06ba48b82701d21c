//! Maps a kernel over the edges of a graph, and keeps its results at the edges.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use super::array::Array;
use super::dense::Aligned;
use super::edges::{EdgePlan, Sources, add_ends_bar};
use super::graph::{Graph, SlotEdge};
use super::kernel::Pullback;
use super::operation::LaneOperation;
use super::row::{Bars, Places, Reach, StepValues, add, load};
use super::uniform::{UniformInputs, UniformKernel};
use crate::real::Real;
use crate::simd::{Lane, Unchecked, lanes};

/// Implements [`Program::map_each_edge`](crate::Program::map_each_edge). Its inputs are those of an
/// [`EdgeMap`](super::edges::EdgeMap).
pub(crate) struct EachEdge<R, K, const C: usize, const I: usize, const O: usize> {
    kernel: K,
    plan: EdgePlan,
    edges: Vec<SlotEdge>,
    /// First `C` arrays over the nodes, then arrays over the slots.
    inputs: [Array; I],
    uniforms: UniformInputs,
    active: [bool; I],
    /// The output arrays over the slots, adjacent in memory.
    results: [Array; O],
    reach: Reach,
    /// Arrays over the slots for the results, or for the cotangents of the differences. Each takes `plan.room` numbers.
    scratch: Aligned<R>,
}

impl<R: Real, K: UniformKernel<I, O>, const C: usize, const I: usize, const O: usize>
    EachEdge<R, K, C, I, O>
{
    pub(crate) fn new(
        kernel: K,
        graph: &Graph,
        ends: [Array; C],
        per_edge: &[Array],
        uniforms: &[Array],
        results: [Array; O],
    ) -> Self {
        assert!(
            C > 0 && O > 0,
            "map_each_edge: the kernel must have ends and results"
        );
        assert_eq!(
            C + per_edge.len(),
            I,
            "map_each_edge: the kernel must have one input for each array in `ends` and in `per_edge`"
        );
        let plan = EdgePlan::new(graph, lanes::<R>());
        let mut inputs = [results[0]; I];
        inputs[..C].copy_from_slice(&ends);
        inputs[C..].copy_from_slice(per_edge);
        let len = |k| if k < C { plan.nodes } else { plan.slots };
        let lens = inputs.iter().enumerate().map(|(k, &array)| (array, len(k)));
        let results_len = |&array| (array, plan.slots);
        Self {
            kernel,
            edges: graph.edges_by_slot(),
            inputs,
            uniforms: UniformInputs::new(uniforms, K::UNIFORMS),
            active: [true; I],
            reach: Reach::new(lens.chain(results.iter().map(results_len))),
            results,
            scratch: Aligned::zeros(C.max(O) * plan.room),
            plan,
        }
    }
}

impl<R, K, const C: usize, const I: usize, const O: usize> LaneOperation<R>
    for EachEdge<R, K, C, I, O>
where
    R: Real,
    K: UniformKernel<I, O>,
{
    fn outputs(&self) -> Vec<Array> {
        self.results.to_vec()
    }
    fn set_active(&mut self, arrays: &[bool]) {
        for k in 0..I {
            self.active[k] = arrays[self.inputs[k].id];
        }
        self.uniforms.set_active(arrays);
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        self.reach.check(parameters, row);
        self.plan.check::<R, L>();
        let EdgePlan { room, .. } = self.plan;
        let computed = &mut self.scratch[..O * room];
        // SAFETY: `reach` was checked, and `computed` has `O` arrays of `room` numbers.
        unsafe {
            let values = StepValues { parameters, row };
            let sources = Sources::<R, C, I>::new(&self.inputs, &self.plan, values);
            let uniforms = self.uniforms.load(K::UNIFORMS, values);
            for &lane in &self.plan.edges {
                let y = self.kernel.eval_with(sources.load::<L>(lane), &uniforms);
                for o in 0..O {
                    y[o].store_at(computed, o * room + lane.scratch);
                }
            }
        }
        let Array { start, len, .. } = self.results[0];
        let results = &mut row[start..start + O * len];
        results.fill(R::zero());
        for &lane in &self.plan.edges {
            let n = L::N.min(len - lane.slot);
            for o in 0..O {
                // SAFETY: as above; the results are adjacent arrays over the slots.
                unsafe {
                    let result = L::load_at(computed, o * room + lane.scratch);
                    // Later registers overwrite the zeros of slots that this one reaches beyond its group.
                    let result = L::select(L::mask(lane.bits), result, L::zero());
                    result.store_n(results, o * len + lane.slot, n);
                }
            }
        }
    }
    #[inline(always)]
    fn reverse_in<L: Lane<R>>(&mut self, values: StepValues<R>, bars: &mut Bars<R>) {
        self.reach.check(values.parameters, values.row);
        self.reach.check(bars.parameters, bars.row);
        self.plan.check::<R, L>();
        let EdgePlan { room, .. } = self.plan;
        let ends_bar = &mut self.scratch[..C * room];
        let places = Places::new(bars);
        let y_bars = places.of_active(&self.results, &[true; O]);
        let x_bars = places.of_active(&self.inputs, &self.active);
        // SAFETY: `reach` was checked, and `ends_bar` has `C` arrays of `room` numbers.
        unsafe {
            let sources = Sources::<R, C, I>::new(&self.inputs, &self.plan, values);
            let uniforms = self.uniforms.load(K::UNIFORMS, values);
            for &lane in &self.plan.edges {
                let mut y_bar = [L::zero(); O];
                for o in 0..O {
                    let bar: L = load(y_bars[o], lane.slot, L::N);
                    y_bar[o] = L::select(L::mask(lane.bits), bar, L::zero());
                }
                let x = sources.load::<L>(lane);
                let at = Pullback {
                    x,
                    y: self.kernel.eval_with(x, &uniforms),
                    y_bar: [y_bar],
                };
                let [x_bar] = self.kernel.vjp_with(at, &uniforms);
                for c in 0..C {
                    x_bar[c].store_at(ends_bar, c * room + lane.scratch);
                }
                for k in C..I {
                    add(x_bars[k], lane.slot, L::N, x_bar[k]);
                }
            }
            if self.active[..C].contains(&true) {
                add_ends_bar::<R, L, C>(&self.plan, ends_bar, &self.inputs[..C], bars);
            }
        }
        if const { K::UNIFORMS > 0 } {
            self.add_uniform_bars(values, bars);
        }
    }
}

impl<R: Real, K: UniformKernel<I, O>, const C: usize, const I: usize, const O: usize>
    EachEdge<R, K, C, I, O>
{
    /// Adds the cotangents of uniform inputs, edge by edge.
    fn add_uniform_bars(&self, values: StepValues<R>, bars: &mut Bars<R>) {
        let at = |bars: &Bars<R>, edge: &SlotEdge| {
            let (mut x, mut y_bar) = ([R::zero(); I], [R::zero(); O]);
            for k in 0..I {
                let numbers = values.get(self.inputs[k]);
                x[k] = match k < C {
                    true => numbers[edge.head] - numbers[edge.tail],
                    false => numbers[edge.slot],
                };
            }
            for k in 0..O {
                y_bar[k] = bars.row[self.results[k].start + edge.slot];
            }
            (edge.slot, x, y_bar)
        };
        (self.uniforms).add_bars(&self.kernel, values, bars, self.edges.iter(), at);
    }
}
