//! Differences along the edges of a graph, and sums over the edges of its nodes.
//!
//! Edges are grouped by the offset of their node numbers. On a lattice there are four such
//! groups, and then both operations load shifted, contiguous data in place of gathering: a
//! group has a **slot** for every node that could be a tail. Slots without an edge are ghosts:
//! they pass nothing on.

use std::sync::Arc;

use super::{Array, Operation, WIDEST};
use crate::lanes::{Lane, Vectorized};
use crate::real::Real;

/// A directed graph, and the slot layout of arrays along its edges.
#[derive(Clone, Debug)]
pub struct Graph(Arc<Layout>);

#[derive(Debug)]
struct Layout {
    nodes: usize,
    groups: Vec<Group>,
    slots: usize,
    slot_of_edge: Vec<usize>,
    /// Per slot, whether it holds an edge.
    real: Vec<bool>,
}

/// Edges `(i, i + offset)`; the slot of tail `i` is `first_slot + i`.
#[derive(Clone, Copy, Debug)]
struct Group {
    offset: usize,
    first_slot: usize,
    /// Slots, in whole lanes.
    len: usize,
}

impl Graph {
    /// A graph from its edges `[tail, head]`, `tail < head`. Meant for lattices: memory grows
    /// with the number of nodes times that of different offsets `head - tail`.
    ///
    /// # Panics
    /// If an edge leaves `0..nodes`, runs downwards, or stands twice.
    pub fn new(nodes: usize, edges: &[[usize; 2]]) -> Self {
        for [i, j] in edges {
            assert!(
                i < j && *j < nodes,
                "edge [{i}, {j}]: not ascending within {nodes} nodes"
            );
        }
        let mut offsets: Vec<usize> = edges.iter().map(|[i, j]| j - i).collect();
        offsets.sort_unstable();
        offsets.dedup();
        let mut slots = 0;
        let mut groups = Vec::new();
        for offset in offsets {
            let len = (nodes - offset).next_multiple_of(WIDEST);
            groups.push(Group {
                offset,
                first_slot: slots,
                len,
            });
            slots += len;
        }
        let mut real = vec![false; slots];
        let mut place = |[i, j]: &[usize; 2]| {
            let group = groups.iter().find(|g| g.offset == j - i);
            let slot = group.map_or(0, |g| g.first_slot) + i;
            assert!(!real[slot], "edge [{i}, {j}] stands twice");
            real[slot] = true;
            slot
        };
        let slot_of_edge = edges.iter().map(&mut place).collect();
        Self(Arc::new(Layout {
            nodes,
            groups,
            slots,
            slot_of_edge,
            real,
        }))
    }

    /// The number of nodes.
    pub fn nodes(&self) -> usize {
        self.0.nodes
    }

    /// The length of arrays along the edges, ghosts included; 0 without edges.
    pub fn slots(&self) -> usize {
        self.0.slots
    }

    /// The slot of every edge.
    pub fn slot_of_edge(&self) -> &[usize] {
        &self.0.slot_of_edge
    }

    /// The edge of every slot, for [`Program::gather`](super::Program::gather).
    pub fn edge_of_slot(&self) -> Vec<Option<usize>> {
        let mut edges = vec![None; self.0.slots];
        for (edge, &slot) in self.0.slot_of_edge.iter().enumerate() {
            edges[slot] = Some(edge);
        }
        edges
    }

    /// Values per edge in the slot layout, zero in ghosts.
    pub fn to_slots<R: Real>(&self, per_edge: &[R]) -> Vec<R> {
        assert_eq!(
            per_edge.len(),
            self.0.slot_of_edge.len(),
            "one value per edge is needed"
        );
        let mut slots = vec![R::zero(); self.0.slots];
        for (&value, &slot) in per_edge.iter().zip(&self.0.slot_of_edge) {
            slots[slot] = value;
        }
        slots
    }

    /// One for edges, zero for ghosts.
    fn ghosts_out<R: Real>(&self) -> Vec<R> {
        self.0
            .real
            .iter()
            .map(|&r| if r { R::one() } else { R::zero() })
            .collect()
    }
}

/// What both operations share. Lanes may reach past a group's last node: such slots are ghosts,
/// and what they would give is replaced by zero.
struct Incidence<R> {
    graph: Graph,
    real: Vec<R>,
    nodes: Array,
    slots: Array,
    active: bool,
}

impl<R: Real> Incidence<R> {
    fn new(graph: Graph, nodes: Array, slots: Array) -> Self {
        let real = graph.ghosts_out();
        Self {
            graph,
            real,
            nodes,
            slots,
            active: true,
        }
    }

    /// The nodes and the slots in the arena, each from its first to the end of what a lane may
    /// reach.
    #[inline(always)]
    fn parts<'a>(&self, arena: &'a mut [R]) -> (&'a mut [R], &'a mut [R]) {
        let (nodes, slots) = (self.nodes.start, self.slots.start);
        let (low, high) = arena.split_at_mut(nodes.max(slots));
        if nodes < slots {
            (&mut low[nodes..], high)
        } else {
            (high, &mut low[slots..])
        }
    }

    /// `slots = [or +=] sign * (head - tail)`.
    #[inline(always)]
    fn spread<L: Lane<R>, const ADD: bool>(&self, arena: &mut [R]) {
        let (nodes, slots) = self.parts(arena);
        for &Group {
            offset,
            first_slot,
            len,
        } in &self.graph.0.groups
        {
            let real = self.real[first_slot..][..len].chunks_exact(L::N);
            let ends = nodes[..len]
                .chunks_exact(L::N)
                .zip(nodes[offset..][..len].chunks_exact(L::N));
            let slots = slots[first_slot..][..len].chunks_exact_mut(L::N);
            for ((slot, real), (tail, head)) in slots.zip(real).zip(ends) {
                let (tail, head) = (L::load(tail), L::load(head));
                if ADD {
                    // The reverse of a sum over edges, in which the tail counts plus.
                    (L::load(slot) + real_only::<R, L>(real, tail - head)).store(slot);
                } else {
                    real_only::<R, L>(real, head - tail).store(slot);
                }
            }
        }
    }

    /// `nodes += slots as tail - slots as head`, or the negative of it.
    #[inline(always)]
    fn collect<L: Lane<R>, const NEGATIVE: bool>(&self, arena: &mut [R]) {
        let (nodes, slots) = self.parts(arena);
        for &Group {
            offset,
            first_slot,
            len,
        } in &self.graph.0.groups
        {
            for (shift, minus) in [(0, NEGATIVE), (offset, !NEGATIVE)] {
                let real = self.real[first_slot..][..len].chunks_exact(L::N);
                let slots = slots[first_slot..][..len].chunks_exact(L::N);
                let nodes = nodes[shift..][..len].chunks_exact_mut(L::N);
                for ((node, slot), real) in nodes.zip(slots).zip(real) {
                    let value = real_only::<R, L>(real, L::load(slot));
                    let old = L::load(node);
                    (if minus { old - value } else { old + value }).store(node);
                }
            }
        }
    }
}

/// The value where there is an edge, zero in ghosts.
#[inline(always)]
fn real_only<R: Real, L: Lane<R>>(real: &[R], value: L) -> L {
    L::select(L::lit(0.5).lt(L::load(real)), value, L::zero())
}

/// Work on an arena in lanes.
struct OnArena<'a, R> {
    incidence: &'a Incidence<R>,
    arena: &'a mut [R],
    work: Work,
}

/// The two operations and their reverses.
enum Work {
    /// `slots = head - tail`.
    Difference,
    /// `nodes -= ...`, the bars of a difference.
    DifferenceBars,
    /// `nodes += ...`.
    Sum,
    /// `slots += tail - head`, the bars of a sum.
    SumBars,
}

impl<R: Real> Vectorized<R> for OnArena<'_, R> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        match self.work {
            Work::Difference => self.incidence.spread::<L, false>(self.arena),
            Work::DifferenceBars => self.incidence.collect::<L, true>(self.arena),
            Work::Sum => self.incidence.collect::<L, false>(self.arena),
            Work::SumBars => self.incidence.spread::<L, true>(self.arena),
        }
    }
}

pub(super) struct Difference<R>(Incidence<R>);

impl<R: Real> Difference<R> {
    pub(super) fn new(graph: Graph, x: Array, output: Array) -> Self {
        Self(Incidence::new(graph, x, output))
    }
}

impl<R: Real> Operation<R> for Difference<R> {
    fn inputs(&self) -> Vec<Array> {
        vec![self.0.nodes]
    }
    fn outputs(&self) -> Vec<Array> {
        vec![self.0.slots]
    }
    fn reverse_reads(&self) -> Vec<Array> {
        Vec::new()
    }
    fn forward(&mut self, values: &mut [R]) {
        R::vectorize(OnArena {
            incidence: &self.0,
            arena: values,
            work: Work::Difference,
        });
    }
    fn reverse(&mut self, _values: &[R], bars: &mut [R]) {
        if self.0.active {
            R::vectorize(OnArena {
                incidence: &self.0,
                arena: bars,
                work: Work::DifferenceBars,
            });
        }
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.0.active = arrays[self.0.nodes.id];
    }
}

pub(super) struct IncidentSum<R>(Incidence<R>);

impl<R: Real> IncidentSum<R> {
    pub(super) fn new(graph: Graph, x: Array, output: Array) -> Self {
        Self(Incidence::new(graph, output, x))
    }
}

impl<R: Real> Operation<R> for IncidentSum<R> {
    fn inputs(&self) -> Vec<Array> {
        vec![self.0.slots]
    }
    fn outputs(&self) -> Vec<Array> {
        vec![self.0.nodes]
    }
    fn reverse_reads(&self) -> Vec<Array> {
        Vec::new()
    }
    fn forward(&mut self, values: &mut [R]) {
        let nodes = self.0.nodes;
        values[nodes.range()].fill(R::zero());
        R::vectorize(OnArena {
            incidence: &self.0,
            arena: values,
            work: Work::Sum,
        });
    }
    fn reverse(&mut self, _values: &[R], bars: &mut [R]) {
        if self.0.active {
            R::vectorize(OnArena {
                incidence: &self.0,
                arena: bars,
                work: Work::SumBars,
            });
        }
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) {
        self.0.active = arrays[self.0.slots.id];
    }
}
