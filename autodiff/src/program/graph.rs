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
    /// The largest offset.
    lead: usize,
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
        let lead = offsets.last().copied().unwrap_or(0);
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
            lead,
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

    /// How far before the first slot a lane may read.
    pub(super) fn lead(&self) -> usize {
        self.0
            .groups
            .iter()
            .map(|group| group.offset)
            .max()
            .unwrap_or(0)
    }
}

/// What both operations share. Lanes may reach past a group's edges: what they read there is
/// passed on neither to a node nor to a ghost.
struct Incidence<R> {
    graph: Graph,
    nodes: Array,
    slots: Array,
    /// Per group and node, in whole lanes: one where the node is the tail of an edge, and where
    /// it is the head of one; else zero.
    is_tail: Vec<R>,
    is_head: Vec<R>,
    /// Per slot: one where there is an edge, else zero.
    is_edge: Vec<R>,
    active: bool,
}

impl<R: Real> Incidence<R> {
    fn new(graph: Graph, nodes: Array, slots: Array) -> Self {
        let stride = graph.0.nodes.next_multiple_of(WIDEST);
        let mut is_tail = vec![R::zero(); graph.0.groups.len() * stride];
        let mut is_head = is_tail.clone();
        for (g, group) in graph.0.groups.iter().enumerate() {
            for tail in 0..graph.0.nodes - group.offset {
                if graph.0.real[group.first_slot + tail] {
                    is_tail[g * stride + tail] = R::one();
                    is_head[g * stride + tail + group.offset] = R::one();
                }
            }
        }
        let one_or_zero = |&real: &bool| if real { R::one() } else { R::zero() };
        Self {
            is_edge: graph.0.real.iter().map(one_or_zero).collect(),
            graph,
            nodes,
            slots,
            is_tail,
            is_head,
            active: true,
        }
    }

    /// The nodes from their first, and the slots from [`lead`](Graph::lead) before their first,
    /// each to the end of what a lane may reach.
    #[inline(always)]
    fn parts<'a>(&self, arena: &'a mut [R]) -> (&'a mut [R], &'a mut [R]) {
        let (nodes, slots) = (self.nodes.start, self.slots.start - self.graph.lead());
        let (low, high) = arena.split_at_mut(nodes.max(slots));
        if nodes < slots {
            (&mut low[nodes..], high)
        } else {
            (high, &mut low[slots..])
        }
    }

    /// `slots = head - tail`, or `slots += tail - head`.
    #[inline(always)]
    fn spread<L: Lane<R>, const ADD: bool>(&self, arena: &mut [R]) {
        let lead = self.graph.lead();
        let (nodes, slots) = self.parts(arena);
        for &Group {
            offset,
            first_slot,
            len,
        } in &self.graph.0.groups
        {
            let tails = nodes[..len].chunks_exact(L::N);
            let heads = nodes[offset..][..len].chunks_exact(L::N);
            let slots = slots[lead + first_slot..][..len].chunks_exact_mut(L::N);
            let is_edge = self.is_edge[first_slot..][..len].chunks_exact(L::N);
            for ((slot, is_edge), (tail, head)) in slots.zip(is_edge).zip(tails.zip(heads)) {
                let (tail, head) = (L::load(tail), L::load(head));
                if ADD {
                    let value = where_edge::<R, L>(is_edge, tail - head);
                    (L::load(slot) + value).store(slot);
                } else {
                    where_edge::<R, L>(is_edge, head - tail).store(slot);
                }
            }
        }
    }

    /// `nodes = sum over edges of (slots as tail - slots as head)`, or `nodes -=` that. Every
    /// node is summed up in a register, its edges in the order of the groups.
    #[inline(always)]
    fn collect<L: Lane<R>, const SUBTRACT: bool>(&self, arena: &mut [R]) {
        let lead = self.graph.lead();
        let stride = self.graph.0.nodes.next_multiple_of(WIDEST);
        let (nodes, slots) = self.parts(arena);
        let nodes = &mut nodes[..self.nodes.len];
        for i in (0..nodes.len()).step_by(L::N) {
            let mut sum = L::zero();
            for (
                g,
                &Group {
                    offset, first_slot, ..
                },
            ) in self.graph.0.groups.iter().enumerate()
            {
                let at = lead + first_slot + i;
                let as_tail = L::load(&slots[at..]);
                let as_head = L::load(&slots[at - offset..]);
                sum += where_edge::<R, L>(&self.is_tail[g * stride + i..], as_tail);
                sum -= where_edge::<R, L>(&self.is_head[g * stride + i..], as_head);
            }
            let to = &mut nodes[i..];
            (if SUBTRACT {
                L::load_up_to(to) - sum
            } else {
                sum
            })
            .store_up_to(to);
        }
    }
}

/// The value where there is an edge, else zero.
#[inline(always)]
fn where_edge<R: Real, L: Lane<R>>(is_edge: &[R], value: L) -> L {
    L::select(L::lit(0.5).lt(L::load(is_edge)), value, L::zero())
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
    /// `nodes -= tail - head`, the bars of a difference.
    DifferenceBars,
    /// `nodes = tail - head`.
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
