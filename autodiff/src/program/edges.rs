//! A kernel mapped over the edges of a graph, its results summed up at their nodes.
#![allow(unsafe_code)] // Unchecked loads: see `Lane::load_at`.

use std::ops::Range;

use super::graph::Graph;
use super::row::Frame;
use super::{Aligned, Array, Bars, Operation, WIDEST, lanes};
use crate::kernel::Adjoint;
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// The kernel's inputs are the `C` differences head less tail, then what is given per edge; its
/// `O` results count plus at the tail and minus at the head.
///
/// Lanes reach past a group's edges, and past the nodes: what they read there is masked.
pub(super) struct EdgeMap<R, K, const C: usize, const I: usize, const O: usize> {
    kernel: K,
    plan: Plan,
    /// Per node.
    ends: [Array; C],
    /// Per slot.
    per_edge: Vec<Array>,
    /// Per node.
    sums: [Array; O],
    /// Results, or cotangents of differences, per slot.
    scratch: Vec<Aligned<R>>,
    ends_active: bool,
    per_edge_active: Vec<bool>,
}

/// A graph as the lanes that are gone through, so that no step works them out again.
struct Plan {
    edges: Vec<LaneOfEdges>,
    ends: Vec<LaneOfEnds>,
    /// For one lane of nodes after the other, which of these lie at them.
    at_nodes: Vec<Range<usize>>,
    /// How many nodes, how many slots and how much scratch lanes touch.
    reach: [usize; 3],
}

/// Slots side by side, and a bit for each that has an edge.
#[derive(Clone, Copy)]
struct LaneOfEdges {
    slot: usize,
    scratch: usize,
    tail: usize,
    head: usize,
    bits: u16,
}

/// The edges of one group at nodes side by side: where the scratch has those of which they are
/// tails, and those of which they are heads; and a bit for each that there is.
#[derive(Clone, Copy)]
struct LaneOfEnds {
    as_tail: usize,
    as_head: usize,
    tails: u16,
    heads: u16,
}

impl Plan {
    fn new(graph: &Graph, lanes: usize) -> Self {
        // Room for the first slots as those of heads; whole lines, as all that is stored is.
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
                        as_head: scratch - group.offset,
                        tails,
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
            reach: [
                reach(|e| e.head),
                reach(|e| e.slot),
                last.map_or(0, |last| last + lanes),
            ],
            at_nodes: ranges(&at_nodes),
            edges,
            ends,
        }
    }
}

/// Where the items of each list are once all lie one after the other.
fn ranges<T>(lists: &[Vec<T>]) -> Vec<Range<usize>> {
    let ends = lists.iter().scan(0, |end, list| {
        *end += list.len();
        Some(*end - list.len()..*end)
    });
    ends.collect()
}

impl<R: Real, K, const C: usize, const I: usize, const O: usize> EdgeMap<R, K, C, I, O> {
    pub(super) fn new(
        kernel: K,
        graph: &Graph,
        (ends, per_edge): ([Array; C], &[Array]),
        sums: [Array; O],
    ) -> Self {
        assert_eq!(
            C + per_edge.len(),
            I,
            "map_edges: the kernel has another number of inputs"
        );
        let plan = Plan::new(graph, lanes::<R>());
        let [.., room] = plan.reach;
        Self {
            kernel,
            ends,
            per_edge_active: vec![true; per_edge.len()],
            per_edge: per_edge.to_vec(),
            sums,
            scratch: (0..C.max(O)).map(|_| Aligned::zeros(room)).collect(),
            ends_active: true,
            plan,
        }
    }

    /// What the edges read.
    ///
    /// # Panics
    /// Unless all that they do lies in its part.
    #[inline(always)]
    fn sources<'a>(&self, values: Frame<'a, R>) -> Sources<'a, R, C, I> {
        let [nodes, slots, _] = self.plan.reach;
        let mut sources = Sources {
            ends: [values.row; C],
            per_edge: [values.row; I],
        };
        for c in 0..C {
            let array = self.ends[c];
            sources.ends[c] = &values.part(array)[array.start..][..nodes];
        }
        for k in C..I {
            let array = self.per_edge[k - C];
            sources.per_edge[k] = &values.part(array)[array.start..][..slots];
        }
        sources
    }
}

/// What the edges read: arrays over the nodes, and over the slots. Of the latter, the last `I - C`
/// are used.
struct Sources<'a, R, const C: usize, const I: usize> {
    ends: [&'a [R]; C],
    per_edge: [&'a [R]; I],
}

impl<R: Real, const C: usize, const I: usize> Sources<'_, R, C, I> {
    /// The kernel's inputs for a lane of edges.
    ///
    /// # Safety
    /// The lane is of the plan whose reach the slices have.
    #[inline(always)]
    unsafe fn load<L: Lane<R>>(&self, lane: LaneOfEdges) -> [L; I] {
        let LaneOfEdges {
            slot, tail, head, ..
        } = lane;
        let edges = L::mask(lane.bits);
        let mut x = [L::zero(); I];
        for c in 0..C {
            // SAFETY, here and below: the caller's promise.
            let stretch =
                unsafe { L::load_at(self.ends[c], head) - L::load_at(self.ends[c], tail) };
            x[c] = L::select(edges, stretch, L::zero());
        }
        for k in C..I {
            x[k] = unsafe { L::load_at(self.per_edge[k], slot) };
        }
        x
    }
}

impl<R, K, const C: usize, const I: usize, const O: usize> Operation<R> for EdgeMap<R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    fn outputs(&self) -> Vec<Array> {
        self.sums.to_vec()
    }
    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        R::vectorize(Forward {
            map: self,
            parameters,
            row,
        });
    }
    fn reverse(&mut self, values: Frame<R>, bars: &mut Bars<R>) {
        R::vectorize(Reverse {
            map: self,
            values,
            bars,
        });
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.ends_active = self.ends.iter().any(|a| arrays[a.id]);
        self.per_edge_active = self.per_edge.iter().map(|a| arrays[a.id]).collect();
    }
}

struct Forward<'a, R, K, const C: usize, const I: usize, const O: usize> {
    map: &'a mut EdgeMap<R, K, C, I, O>,
    parameters: &'a [R],
    row: &'a mut [R],
}

impl<R, K, const C: usize, const I: usize, const O: usize> Vectorized<R>
    for Forward<'_, R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self {
            map,
            parameters,
            row,
        } = self;
        let sources = map.sources(Frame { parameters, row });
        let results = slices::<R, O>(&mut map.scratch, &map.plan);
        for &lane in &map.plan.edges {
            // SAFETY: the sources and the results have the plan's reach.
            unsafe {
                let y = map.kernel.eval(sources.load::<L>(lane));
                for o in 0..O {
                    y[o].store_at(results[o], lane.scratch);
                }
            }
        }
        let Array { start, len, .. } = map.sums[0];
        let sums = &mut row[start..start + O * len];
        collect::<R, L, O>(&map.plan, &results, len, |o, (node, n), sum| {
            // SAFETY: the sums lie one after the other, and the nodes are theirs.
            unsafe { sum.store_n(sums, (o * len + node, n)) };
        });
    }
}

struct Reverse<'a, 'b, R, K, const C: usize, const I: usize, const O: usize> {
    map: &'a mut EdgeMap<R, K, C, I, O>,
    values: Frame<'a, R>,
    bars: &'a mut Bars<'b, R>,
}

impl<R, K, const C: usize, const I: usize, const O: usize> Vectorized<R>
    for Reverse<'_, '_, R, K, C, I, O>
where
    R: Real,
    K: Adjoint<I, O>,
{
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        let Self { map, values, bars } = self;
        let sources = map.sources(values);
        let [nodes, slots, _] = map.plan.reach;
        for sum in &map.sums {
            assert!(
                sum.start + nodes <= bars.row.len(),
                "sums outside their row"
            );
        }
        let mut wanted = [None; I];
        for k in C..I {
            let (array, active) = (map.per_edge[k - C], map.per_edge_active[k - C]);
            let fits = array.start + slots <= bars.part(array).len();
            assert!(fits, "slots outside their part");
            wanted[k] = active.then_some(array);
        }
        let ends_bar = slices::<R, C>(&mut map.scratch, &map.plan);
        for &lane in &map.plan.edges {
            // SAFETY: all that is read and written was checked to have the plan's reach.
            unsafe {
                let mut y_bar = [L::zero(); O];
                for o in 0..O {
                    let sums = map.sums[o].start;
                    let head = L::load_at(bars.row, sums + lane.head);
                    let tail_less_head = L::load_at(bars.row, sums + lane.tail) - head;
                    y_bar[o] = L::select(L::mask(lane.bits), tail_less_head, L::zero());
                }
                let x_bar = map.kernel.vjp(sources.load::<L>(lane), y_bar);
                for c in 0..C {
                    x_bar[c].store_at(ends_bar[c], lane.scratch);
                }
                for k in C..I {
                    if let Some(array) = wanted[k] {
                        let (part, place) = (bars.part_mut(array), array.start + lane.slot);
                        (L::load_at(part, place) + x_bar[k]).store_at(part, place);
                    }
                }
            }
        }
        if map.ends_active {
            for end in map.ends {
                let fits = end.start + end.len <= bars.part(end).len();
                assert!(fits, "ends outside their part");
            }
            collect::<R, L, C>(
                &map.plan,
                &ends_bar,
                map.ends[0].len,
                |c, (node, n), sum| {
                    let (part, at) = (bars.part_mut(map.ends[c]), (map.ends[c].start + node, n));
                    // SAFETY: the nodes lie in their part, as was checked.
                    unsafe { (L::load_n(part, at) - sum).store_n(part, at) };
                },
            );
        }
    }
}

/// The first of the scratch, as far as a plan's lanes reach.
#[inline(always)]
fn slices<'a, R: Real, const N: usize>(
    scratch: &'a mut [Aligned<R>],
    plan: &Plan,
) -> [&'a mut [R]; N] {
    let [.., room] = plan.reach;
    let mut slices = [(); N].map(|()| &mut [][..]);
    for (slice, scratch) in slices.iter_mut().zip(scratch) {
        *slice = &mut scratch[..room];
    }
    slices
}

/// For every lane of nodes and every array of values per slot, the sum over the nodes' edges,
/// plus where a node is the tail and minus where it is the head; with the lane's first node, and
/// how many there are.
#[inline(always)]
fn collect<R: Real, L: Lane<R>, const N: usize>(
    plan: &Plan,
    values: &[&mut [R]; N],
    nodes: usize,
    mut take: impl FnMut(usize, (usize, usize), L),
) {
    for (k, at_node) in plan.at_nodes.iter().enumerate() {
        let node = k * L::N;
        let mut sums = [L::zero(); N];
        for lane in &plan.ends[at_node.clone()] {
            let [tails, heads] = [lane.tails, lane.heads].map(L::mask);
            for n in 0..N {
                // SAFETY: the values have the plan's reach.
                let (as_tail, as_head) = unsafe {
                    let tail = L::load_at(values[n], lane.as_tail);
                    (tail, L::load_at(values[n], lane.as_head))
                };
                sums[n] += L::select(tails, as_tail, L::zero());
                sums[n] -= L::select(heads, as_head, L::zero());
            }
        }
        for n in 0..N {
            take(n, (node, L::N.min(nodes - node)), sums[n]);
        }
    }
}
