//! Maps a kernel over the edges of a graph, and sums its results at the nodes or keeps them at the edges.
#![allow(unsafe_code)] // Unchecked loads: see `Unchecked::load_at`.

use std::ops::Range;

use autodiff::Real;
use autodiff::internal::{Unchecked, WIDEST, lanes_with};
use autodiff::simd::Lane;

use super::array::Array;
use super::dense::Aligned;
use super::graph::Graph;
use super::kernel::{Kernel, Pullback};
use super::operation::LaneOperation;
use super::row::{BarPointers, Bars, Reach, StepValues, add, load};
use super::uniform::UniformInputs;

/// An operation that applies a kernel to each edge of a graph. The first `C` inputs of the kernel are differences of
/// node values (head minus tail). The other inputs come from arrays with one number per edge. If `SUMS` is true, each of
/// the `O` results is added to a sum at the edge's tail and subtracted from the sum at its head. Otherwise the results
/// stay at the edge.
///
/// Registers may extend past the edges of a group and past the nodes. A mask discards the numbers that they read there.
pub(crate) struct EdgeMap<R, K, const C: usize, const I: usize, const O: usize, const SUMS: bool> {
    kernel: K,
    plan: EdgePlan,
    /// First `C` arrays over the nodes, then arrays over the slots.
    inputs: [Array; I],
    uniforms: UniformInputs,
    active: [bool; I],
    /// The output arrays, adjacent in memory: over the nodes if `SUMS` is true, otherwise over the slots.
    outputs: [Array; O],
    reach: Reach,
    /// Arrays with one number per slot. The forward step stores the results of the kernel here, and the reverse step
    /// the cotangents of the differences. Each array takes `plan.room` numbers.
    scratch: Aligned<R>,
}

/// Assigns the edges and nodes of a graph to registers. The plan is the same for all steps.
struct EdgePlan {
    edges: Vec<LaneOfEdges>,
    ends: Vec<LaneOfEnds>,
    /// For each register of nodes, the range of its entries in `ends`.
    at_nodes: Vec<Range<usize>>,
    /// The numbers of nodes and of slots that accesses of whole registers may reach.
    nodes: usize,
    slots: usize,
    /// The length of each array in `scratch`.
    room: usize,
    /// The number of lanes in a register.
    width: usize,
}

/// A register of adjacent slots, described by its first slot. `slot` is the position of the first slot in arrays over
/// the slots, `scratch` its position in `scratch`. `tail` and `head` are the positions of its two nodes in arrays over
/// the nodes.
#[derive(Clone, Copy)]
struct LaneOfEdges {
    slot: usize,
    scratch: usize,
    tail: usize,
    head: usize,
    /// A bit for each slot that holds an edge.
    bits: u16,
}

/// The edges of one group that begin or end at a register of adjacent nodes.
#[derive(Clone, Copy)]
struct LaneOfEnds {
    /// The position in `scratch` of the edges whose tail is one of the register's nodes. `tails` has a bit for each
    /// edge that exists.
    as_tail: usize,
    tails: u16,
    /// The position in `scratch` of the edges whose head is one of the register's nodes. `heads` has a bit for each
    /// edge that exists.
    as_head: usize,
    heads: u16,
}

impl EdgePlan {
    fn new(graph: &Graph, lanes: usize) -> Self {
        // The edges whose head is a node are read from a position in `scratch` that is lower by `offset`. Unused room
        // at the beginning of `scratch` ensures that this position is never negative.
        let lead = graph.lead().next_multiple_of(WIDEST);
        let mut edges = Vec::new();
        let mut at_nodes = vec![Vec::new(); graph.nodes().div_ceil(lanes)];
        for group in graph.groups() {
            let [tails, heads] = [&group.is_tail, &group.is_head].map(|bits| bits.by_lanes(lanes));
            for (lane, (tails, heads)) in tails.into_iter().zip(heads).enumerate() {
                let tail = lane * lanes;
                let (slot, head) = (group.first_slot + tail, tail + group.offset);
                let scratch = lead + slot;
                if tails != 0 {
                    edges.push(LaneOfEdges {
                        slot,
                        scratch,
                        tail,
                        head,
                        bits: tails,
                    });
                }
                if tails | heads != 0 {
                    at_nodes[lane].push(LaneOfEnds {
                        as_tail: scratch,
                        tails,
                        as_head: scratch - group.offset,
                        heads,
                    });
                }
            }
        }
        let reach = |of: fn(&LaneOfEdges) -> usize| {
            let last = edges.iter().map(of).max();
            last.map_or(0, |last| last + lanes)
        };
        let ends: Vec<LaneOfEnds> = at_nodes.concat();
        let last = ends.iter().map(|e| e.as_tail).max();
        Self {
            nodes: reach(|e| e.head),
            slots: reach(|e| e.slot),
            room: last.map_or(0, |last| (last + lanes).next_multiple_of(WIDEST)),
            at_nodes: ranges(&at_nodes),
            edges,
            ends,
            width: lanes,
        }
    }

    /// The first node of register `k`, and how many of the register's lanes are nodes if there are `nodes` nodes.
    #[inline(always)]
    fn nodes_of<R: Real, L: Lane<R>>(&self, k: usize, nodes: usize) -> (usize, usize) {
        let first = k * L::N;
        (first, L::N.min(nodes - first))
    }

    /// For each node of register `k`, sums the values of its edges: values of edges whose tail is the node are added, values
    /// of edges whose head is the node are subtracted. `values` holds `N` arrays over the slots.
    ///
    /// This takes no closure to which it would pass the sums: the compiler does not always inline one.
    #[inline(always)]
    fn sums<R: Real, L: Lane<R>, const N: usize>(&self, values: &[R], k: usize) -> [L; N] {
        assert!(
            N * self.room <= values.len(),
            "`values` is too short: it must hold {N} arrays of {} numbers",
            self.room
        );
        // Each node's sum is completed before the next, so it is stored once and its terms have a fixed order.
        let mut sums = [L::zero(); N];
        for lane in &self.ends[self.at_nodes[k].clone()] {
            let [tails, heads] = [L::mask(lane.tails), L::mask(lane.heads)];
            for n in 0..N {
                // SAFETY: the plan's positions are less than `room`, and `values` has `N` arrays of `room` numbers.
                let (as_tail, as_head) = unsafe {
                    let tail = L::load_at(values, n * self.room + lane.as_tail);
                    (tail, L::load_at(values, n * self.room + lane.as_head))
                };
                sums[n] += L::select(tails, as_tail, L::zero());
                sums[n] -= L::select(heads, as_head, L::zero());
            }
        }
        sums
    }

    /// # Panics
    /// If a register does not have the planned number of lanes. A number type that is defined by a user could change
    /// its number of lanes.
    #[inline(always)]
    fn check<R: Real, L: Lane<R>>(&self) {
        assert_eq!(
            L::N,
            self.width,
            "the number type changed its number of lanes; it must stay the same"
        );
    }
}

/// Returns the range of each list in the concatenation of all lists.
fn ranges<T>(lists: &[Vec<T>]) -> Vec<Range<usize>> {
    let ends = lists.iter().scan(0, |end, list| {
        *end += list.len();
        Some(*end - list.len()..*end)
    });
    ends.collect()
}

impl<R, K, const C: usize, const I: usize, const O: usize, const SUMS: bool>
    EdgeMap<R, K, C, I, O, SUMS>
where
    R: Real,
    K: Kernel<I, O>,
{
    pub(crate) fn new(
        kernel: K,
        graph: &Graph,
        inputs: [Array; I],
        uniforms: &[Array],
        outputs: [Array; O],
    ) -> Self {
        let plan = EdgePlan::new(graph, lanes_with::<R>(K::COMPILED.has_512()));
        let len = |k| if k < C { plan.nodes } else { plan.slots };
        let lens = inputs.iter().enumerate().map(|(k, &array)| (array, len(k)));
        let reached = if SUMS {
            plan.nodes.max(graph.nodes())
        } else {
            plan.slots
        };
        Self {
            kernel,
            inputs,
            uniforms: UniformInputs::new(uniforms),
            active: [true; I],
            reach: Reach::new(lens.chain(outputs.iter().map(|&array| (array, reached)))),
            outputs,
            scratch: Aligned::zeros(C.max(O) * plan.room),
            plan,
        }
    }
}

/// For each input, the slice of its numbers. Arrays over the nodes come first, then arrays over the slots.
struct Sources<'a, R, const C: usize, const I: usize>([&'a [R]; I]);

impl<'a, R: Real, const C: usize, const I: usize> Sources<'a, R, C, I> {
    /// # Safety
    /// The caller must have checked `reach` for these values.
    #[inline(always)]
    unsafe fn new(inputs: &[Array; I], plan: &EdgePlan, values: StepValues<'a, R>) -> Self {
        let mut sources = [values.row; I];
        for k in 0..I {
            let len = if k < C { plan.nodes } else { plan.slots };
            // SAFETY: guaranteed by the caller.
            sources[k] = unsafe { values.reached(inputs[k], len) };
        }
        Self(sources)
    }

    /// Loads the kernel's inputs for a register of edges.
    ///
    /// # Safety
    /// The register must belong to the plan.
    #[inline(always)]
    unsafe fn load<L: Lane<R>>(&self, lane: LaneOfEdges) -> [L; I] {
        let LaneOfEdges {
            slot, tail, head, ..
        } = lane;
        let edges = L::mask(lane.bits);
        let mut x = [L::zero(); I];
        for k in 0..I {
            // SAFETY, here and below: guaranteed by the caller.
            x[k] = if k < C {
                let stretch = unsafe { L::load_at(self.0[k], head) - L::load_at(self.0[k], tail) };
                L::select(edges, stretch, L::zero())
            } else {
                unsafe { L::load_at(self.0[k], slot) }
            };
        }
        x
    }
}

impl<R, K, const C: usize, const I: usize, const O: usize, const SUMS: bool> LaneOperation<R>
    for EdgeMap<R, K, C, I, O, SUMS>
where
    R: Real,
    K: Kernel<I, O>,
{
    const HAS_SCALARS: bool = false;
    const HAS_512: bool = K::COMPILED.has_512();
    fn outputs(&self) -> Vec<Array> {
        self.outputs.to_vec()
    }
    fn set_active(&mut self, arrays: &[bool]) -> bool {
        for k in 0..I {
            self.active[k] = arrays[self.inputs[k].id];
        }
        self.active.contains(&true)
    }
    #[inline(always)]
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]) {
        self.reach.check(parameters, row);
        self.plan.check::<R, L>();
        let EdgePlan { room, .. } = self.plan;
        let results = &mut self.scratch[..O * room];
        // SAFETY: `reach` was checked, and `results` has `O` arrays of `room` numbers.
        unsafe {
            let values = StepValues { parameters, row };
            let sources = Sources::<R, C, I>::new(&self.inputs, &self.plan, values);
            let mut uniforms = self.uniforms.load(K::UNIFORMS, values);
            let uniforms = &mut uniforms[..K::UNIFORMS];
            // The kernel writes its results to `scratch`. They are summed or copied below.
            for &lane in &self.plan.edges {
                if const { !K::COMPILED.has_512() } {
                    self.uniforms.turn(uniforms, values, lane.slot);
                }
                let x = sources.load::<L>(lane);
                let y = self.kernel.eval(x, uniforms);
                for o in 0..O {
                    y[o].store_at(results, o * room + lane.scratch);
                }
            }
        }
        let Array { start, len, .. } = self.outputs[0];
        let outputs = &mut row[start..start + O * len];
        if !SUMS {
            outputs.fill(R::zero());
            for &lane in &self.plan.edges {
                let n = L::N.min(len - lane.slot);
                for o in 0..O {
                    // SAFETY: as above; the outputs are adjacent arrays over the slots.
                    unsafe {
                        let result = L::load_at(results, o * room + lane.scratch);
                        // Later registers overwrite the zeros of slots that this one reaches beyond its group.
                        let result = L::select(L::mask(lane.bits), result, L::zero());
                        result.store_n(outputs, o * len + lane.slot, n);
                    }
                }
            }
            return;
        }
        for k in 0..self.plan.at_nodes.len() {
            let (at, n) = self.plan.nodes_of::<R, L>(k, len);
            let of_nodes = self.plan.sums::<R, L, O>(results, k);
            for o in 0..O {
                // SAFETY: the outputs are adjacent arrays over the nodes, and `at..at + n` are nodes.
                unsafe { of_nodes[o].store_n(outputs, o * len + at, n) };
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
        let pointers = BarPointers::new(bars);
        let y_bars = pointers.of_active(&self.outputs, &[true; O]);
        let x_bars = pointers.of_active(&self.inputs, &self.active);
        // SAFETY: `reach` was checked, and `ends_bar` has `C` arrays of `room` numbers.
        unsafe {
            let sources = Sources::<R, C, I>::new(&self.inputs, &self.plan, values);
            let mut uniforms = self.uniforms.load(K::UNIFORMS, values);
            let uniforms = &mut uniforms[..K::UNIFORMS];
            for &lane in &self.plan.edges {
                if const { !K::COMPILED.has_512() } {
                    self.uniforms.turn(uniforms, values, lane.slot);
                }
                // A result that was added at the tail and subtracted at the head has the tail's cotangent minus the
                // head's. For ghosts (slots without an edge) it is zero.
                let mut y_bar = [L::zero(); O];
                for o in 0..O {
                    let of_edge: L = if SUMS {
                        let head: L = load(y_bars[o], lane.head, L::N);
                        load::<R, L>(y_bars[o], lane.tail, L::N) - head
                    } else {
                        load(y_bars[o], lane.slot, L::N)
                    };
                    y_bar[o] = L::select(L::mask(lane.bits), of_edge, L::zero());
                }
                let x = sources.load::<L>(lane);
                let at = Pullback {
                    x,
                    uniforms,
                    y: self.kernel.eval(x, uniforms),
                    y_bar: [y_bar],
                };
                let [x_bar] = self.kernel.vjp(at);
                for c in 0..C {
                    x_bar[c].store_at(ends_bar, c * room + lane.scratch);
                }
                for k in C..I {
                    add(x_bars[k], lane.slot, L::N, x_bar[k]);
                }
            }
        }
        // A difference is head minus tail, so its cotangent is subtracted at the tail and added at the head.
        if self.active[..C].contains(&true) {
            for k in 0..self.plan.at_nodes.len() {
                let (node, n) = self.plan.nodes_of::<R, L>(k, self.inputs[0].len);
                let sums = self.plan.sums::<R, L, C>(ends_bar, k);
                for c in 0..C {
                    let end = self.inputs[c];
                    let (part, at) = (bars.part_mut(end), end.start + node);
                    // SAFETY: the nodes are within the checked reach.
                    unsafe { (L::load_n(part, at, n) - sums[c]).store_n(part, at, n) };
                }
            }
        }
    }
}
