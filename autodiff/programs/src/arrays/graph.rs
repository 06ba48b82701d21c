//! Graphs whose edges are stored for SIMD lanes.
//!
//! Edges are grouped by their offset, `head - tail`. A square lattice with diagonals has four groups. In a group, the
//! ends of neighbouring edges are adjacent, so registers load them without gathering. A group has a **slot** for every
//! node that could be a tail. A slot without an edge is called a ghost and is skipped.

use std::collections::BTreeSet;
use std::sync::Arc;

use autodiff::Real;
use autodiff::internal::WIDEST;

/// A directed graph. Arrays over its edges have one number for each slot, see [`slots`](Graph::slots).
#[derive(Clone, Debug)]
pub struct Graph(Arc<SlotLayout>);

#[derive(Clone, Debug)]
struct SlotLayout {
    nodes: usize,
    groups: Vec<OffsetGroup>,
    slots: usize,
    slot_of_edge: Vec<usize>,
}

/// An edge: its slot and its two nodes.
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
#[derive(Clone, Copy, Debug)]
pub struct SlotEdge {
    pub slot: usize,
    pub tail: usize,
    pub head: usize,
}

/// The edges `(i, i + offset)`. The slot of tail `i` is `first_slot + i`.
#[derive(Clone, Debug)]
pub(super) struct OffsetGroup {
    pub(super) offset: usize,
    pub(super) first_slot: usize,
    /// The number of slots, a multiple of the lane count of the widest register.
    pub(super) len: usize,
    /// For each node, whether it is the tail of an edge in this group. If so, its slot holds that edge. `is_head` says
    /// for each node whether it is the head of an edge in this group.
    pub(super) is_tail: Bits,
    pub(super) is_head: Bits,
}

impl OffsetGroup {
    fn has(&self, slot: usize) -> bool {
        (self.first_slot..self.first_slot + self.len).contains(&slot)
    }
}

/// A list of bits. Each word has one bit for each lane of the widest register.
#[derive(Clone, Debug)]
pub(super) struct Bits(Vec<u16>);

impl Bits {
    fn none(len: usize) -> Self {
        Self(vec![0; len.div_ceil(WIDEST)])
    }
    fn set(&mut self, place: usize) {
        self.0[place / WIDEST] |= 1 << (place % WIDEST);
    }
    fn clear(&mut self, place: usize) {
        self.0[place / WIDEST] &= !(1 << (place % WIDEST));
    }
    fn get(&self, place: usize) -> bool {
        self.0[place / WIDEST] >> (place % WIDEST) & 1 == 1
    }
    /// Repeats every bit `times` times.
    fn repeated(&self, times: usize) -> Self {
        let mut bits = Self::none(self.0.len() * WIDEST * times);
        for place in (0..self.0.len() * WIDEST).filter(|&place| self.get(place)) {
            for copy in 0..times {
                bits.set(place * times + copy);
            }
        }
        bits
    }
    /// Splits the bits into words for registers of `lanes` lanes.
    pub(super) fn by_lanes(&self, lanes: usize) -> Vec<u16> {
        let of_register = u16::MAX >> (WIDEST - lanes);
        let words = self.0.iter().flat_map(|&word| {
            let shifts = (0..WIDEST).step_by(lanes);
            shifts.map(move |shift| word >> shift & of_register)
        });
        words.collect()
    }
}

impl Graph {
    /// Creates a graph from its edges `[tail, head]`, where `tail < head < nodes`. Graphs are meant for lattices: the
    /// memory is proportional to the number of nodes times the number of different offsets `head - tail`.
    ///
    /// # Panics
    /// If an edge is not ascending, is out of range, or is given twice.
    #[track_caller]
    pub fn new(nodes: usize, edges: &[[usize; 2]]) -> Self {
        for [i, j] in edges {
            assert!(
                i < j && *j < nodes,
                "edge [{i}, {j}] must have tail < head < {nodes}, the number of nodes"
            );
        }
        let offsets: BTreeSet<usize> = edges.iter().map(|[i, j]| j - i).collect();
        let mut slots = 0;
        let mut groups = Vec::new();
        for offset in offsets {
            // A group has whole registers of slots, so no register holds slots of two groups.
            let len = (nodes - offset).next_multiple_of(WIDEST);
            let [is_tail, is_head] = [(); 2].map(|()| Bits::none(nodes));
            groups.push(OffsetGroup {
                offset,
                first_slot: slots,
                len,
                is_tail,
                is_head,
            });
            slots += len;
        }
        // An edge's slot is the first slot of its group plus its tail.
        let mut slot_of_edge = Vec::with_capacity(edges.len());
        for [i, j] in edges {
            let known = groups.iter_mut().find(|group| group.offset == j - i);
            let group = known.expect("a group exists for every offset");
            assert!(!group.is_tail.get(*i), "edge [{i}, {j}] is given twice");
            group.is_tail.set(*i);
            group.is_head.set(*j);
            slot_of_edge.push(group.first_slot + i);
        }
        Self(Arc::new(SlotLayout {
            nodes,
            groups,
            slots,
            slot_of_edge,
        }))
    }

    /// Returns this graph without the edges for which `marked` is true. Nodes, slots and edge numbers stay the same;
    /// the slots of removed edges become ghosts. [`Program::map_edges`](crate::Program::map_edges) skips registers that
    /// hold only ghosts.
    ///
    /// # Panics
    /// If `marked` does not have one value for each edge.
    #[must_use]
    #[track_caller]
    pub fn without(&self, marked: &[bool]) -> Self {
        let mut layout = SlotLayout::clone(&self.0);
        assert_eq!(
            marked.len(),
            layout.slot_of_edge.len(),
            "Graph::without: `marked` must have one value for each edge"
        );
        let slots = layout.slot_of_edge.iter().zip(marked);
        for (&slot, _) in slots.filter(|(_, marked)| **marked) {
            let group = layout.groups.iter_mut().find(|group| group.has(slot));
            let group = group.expect("a group exists for every slot");
            let tail = slot - group.first_slot;
            group.is_tail.clear(tail);
            group.is_head.clear(tail + group.offset);
        }
        Self(Arc::new(layout))
    }

    /// Returns `count` interleaved copies of this graph: node `i` of copy `k` is node `i * count + k`, and likewise for
    /// slots. [`slot_of_edge`](Self::slot_of_edge) returns the slots of copy 0.
    pub(crate) fn side_by_side(&self, count: usize) -> Self {
        if count == 1 {
            return self.clone();
        }
        let layout = &self.0;
        let group = |group: &OffsetGroup| OffsetGroup {
            offset: group.offset * count,
            first_slot: group.first_slot * count,
            len: group.len * count,
            is_tail: group.is_tail.repeated(count),
            is_head: group.is_head.repeated(count),
        };
        Self(Arc::new(SlotLayout {
            nodes: layout.nodes * count,
            groups: layout.groups.iter().map(group).collect(),
            slots: layout.slots * count,
            slot_of_edge: layout.slot_of_edge.iter().map(|s| s * count).collect(),
        }))
    }

    /// The number of nodes.
    pub fn nodes(&self) -> usize {
        self.0.nodes
    }

    /// The number of slots including ghosts. Arrays over the edges have this length.
    pub fn slots(&self) -> usize {
        self.0.slots
    }

    /// The slot of each edge, including edges that were [removed](Graph::without).
    pub fn slot_of_edge(&self) -> &[usize] {
        &self.0.slot_of_edge
    }

    /// For each slot, the edge in it or `None` for a ghost. Use it with [`Program::gather`](crate::Program::gather).
    /// For values that are the same in all steps, call [`to_slots`](Graph::to_slots) once before the rollout instead.
    pub fn edge_of_slot(&self) -> Vec<Option<usize>> {
        let mut edges = vec![None; self.0.slots];
        for (edge, &slot) in self.0.slot_of_edge.iter().enumerate() {
            edges[slot] = self.holds(slot).then_some(edge);
        }
        edges
    }

    /// For each slot, the nodes `[tail, head]` of the edge in it or `None` for a ghost. With it,
    /// [`Program::gather`](crate::Program::gather) brings numbers of the nodes to the edges.
    pub fn nodes_of_slot(&self) -> Vec<Option<[usize; 2]>> {
        let mut nodes = vec![None; self.0.slots];
        for edge in self.edges_by_slot() {
            nodes[edge.slot] = Some([edge.tail, edge.head]);
        }
        nodes
    }

    /// Whether this slot holds an edge. A slot without an edge is called a ghost.
    fn holds(&self, slot: usize) -> bool {
        let holds = |group: &OffsetGroup| group.is_tail.get(slot - group.first_slot);
        let mut groups = self.0.groups.iter();
        groups.find(|group| group.has(slot)).is_some_and(holds)
    }

    /// Returns an array over the slots: the slot of each edge gets the edge's value, and ghosts get zero.
    ///
    /// # Panics
    /// If `per_edge` does not have one value for each edge.
    #[track_caller]
    pub fn to_slots<R: Real>(&self, per_edge: &[R]) -> Vec<R> {
        assert_eq!(
            per_edge.len(),
            self.0.slot_of_edge.len(),
            "Graph::to_slots: `per_edge` must have one value for each edge"
        );
        let mut slots = vec![R::zero(); self.0.slots];
        let places = per_edge.iter().zip(&self.0.slot_of_edge);
        for (&value, &slot) in places.filter(|(_, slot)| self.holds(**slot)) {
            slots[slot] = value;
        }
        slots
    }

    /// The edges that have not been removed, ordered by slot.
    pub(crate) fn edges_by_slot(&self) -> Vec<SlotEdge> {
        let of_group = |group: &OffsetGroup| {
            let OffsetGroup {
                offset,
                first_slot,
                is_tail,
                ..
            } = group.clone();
            let tails = (0..self.0.nodes).filter(move |&tail| is_tail.get(tail));
            tails.map(move |tail| SlotEdge {
                slot: first_slot + tail,
                tail,
                head: tail + offset,
            })
        };
        self.0.groups.iter().flat_map(of_group).collect()
    }

    /// The largest offset of a group. A register may begin this many slots before the first slot.
    #[inline(always)]
    pub(crate) fn lead(&self) -> usize {
        self.0.groups.last().map_or(0, |group| group.offset)
    }

    #[inline(always)]
    pub(super) fn groups(&self) -> &[OffsetGroup] {
        &self.0.groups
    }
}
