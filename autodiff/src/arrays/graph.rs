//! Graphs whose edges are stored for work in lanes.
//!
//! Edges are grouped by their offset, the difference of their node numbers. A square lattice with
//! diagonals has four groups. Within a group the ends of neighbouring edges are adjacent, so registers load
//! them without gathering. A group has a **slot** for every node that could be a tail. A slot without an edge
//! is a ghost and is skipped.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::real::Real;
use crate::simd::{WIDEST, lanes};

/// A directed graph, and the layout of arrays over its edges in slots.
#[derive(Clone, Debug)]
pub struct Graph(Arc<SlotLayout>);

#[derive(Clone, Debug)]
struct SlotLayout {
    nodes: usize,
    groups: Vec<OffsetGroup>,
    slots: usize,
    slot_of_edge: Vec<usize>,
}

/// The slot and the nodes of an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlotEdge {
    pub(crate) slot: usize,
    pub(crate) tail: usize,
    pub(crate) head: usize,
}

/// Edges `(i, i + offset)`; the slot of tail `i` is `first_slot + i`.
#[derive(Clone, Debug)]
pub(super) struct OffsetGroup {
    pub(super) offset: usize,
    pub(super) first_slot: usize,
    /// The number of slots, a multiple of the lanes of the widest register.
    pub(super) len: usize,
    /// Whether each node is the tail of an edge, so that its slot holds one, and whether it is the head of one.
    pub(super) is_tail: Bits,
    pub(super) is_head: Bits,
}

impl OffsetGroup {
    fn has(&self, slot: usize) -> bool {
        (self.first_slot..self.first_slot + self.len).contains(&slot)
    }
}

/// A bit per place, in words with one bit for each lane of the widest register.
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
    /// The bits of each register of this many lanes.
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
    /// Creates a graph from its edges `[tail, head]`, where `tail < head < nodes`. Graphs are meant for lattices:
    /// the memory is proportional to the nodes times the number of different offsets `head - tail`.
    ///
    /// # Panics
    /// If an edge is out of range, does not ascend, or is given twice.
    pub fn new(nodes: usize, edges: &[[usize; 2]]) -> Self {
        for [i, j] in edges {
            assert!(
                i < j && *j < nodes,
                "edge [{i}, {j}] must ascend and stay below {nodes}, the number of nodes"
            );
        }
        let offsets: BTreeSet<usize> = edges.iter().map(|[i, j]| j - i).collect();
        let mut slots = 0;
        let mut groups = Vec::new();
        for offset in offsets {
            // Groups are whole registers, so no register has slots of two groups.
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
        // An edge's slot is its group's first slot plus its tail.
        let place = |[i, j]: &[usize; 2]| {
            let known = groups.iter_mut().find(|group| group.offset == j - i);
            let group = known.expect("every offset has its group");
            assert!(!group.is_tail.get(*i), "edge [{i}, {j}] is given twice");
            group.is_tail.set(*i);
            group.is_head.set(*j);
            group.first_slot + i
        };
        let slot_of_edge = edges.iter().map(place).collect();
        Self(Arc::new(SlotLayout {
            nodes,
            groups,
            slots,
            slot_of_edge,
        }))
    }

    /// Returns this graph without the edges that are marked. Nodes, slots and the numbers of edges stay. The slots
    /// of the marked edges become ghosts. [`Program::map_edges`](crate::Program::map_edges) skips registers that
    /// hold only ghosts.
    ///
    /// # Panics
    /// If the number of marks is not the number of edges.
    #[must_use]
    pub fn without(&self, marked: &[bool]) -> Self {
        let mut layout = SlotLayout::clone(&self.0);
        assert_eq!(
            marked.len(),
            layout.slot_of_edge.len(),
            "`Graph::without` needs one mark for each edge"
        );
        let slots = layout.slot_of_edge.iter().zip(marked);
        for (&slot, _) in slots.filter(|(_, marked)| **marked) {
            let group = layout.groups.iter_mut().find(|group| group.has(slot));
            let group = group.expect("every slot has its group");
            let tail = slot - group.first_slot;
            group.is_tail.clear(tail);
            group.is_head.clear(tail + group.offset);
        }
        Self(Arc::new(layout))
    }

    /// `count` interleaved copies of this graph: node `i` of copy `k` is `i * count + k`, and likewise for slots.
    /// Edges keep the numbers of the first copy.
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

    /// The number of slots including ghosts, which is the length of arrays over the edges.
    pub fn slots(&self) -> usize {
        self.0.slots
    }

    /// The slot of every edge, including edges that are [left out](Graph::without).
    pub fn slot_of_edge(&self) -> &[usize] {
        &self.0.slot_of_edge
    }

    /// The edge of every slot, for [`Program::gather`](crate::Program::gather); `None` for ghosts. For values that
    /// no step changes, call [`to_slots`](Graph::to_slots) once before the rollout instead.
    pub fn edge_of_slot(&self) -> Vec<Option<usize>> {
        let mut edges = vec![None; self.0.slots];
        for (edge, &slot) in self.0.slot_of_edge.iter().enumerate() {
            edges[slot] = self.holds(slot).then_some(edge);
        }
        edges
    }

    /// The number of registers of `R` that hold at least one edge, on this machine.
    pub fn lanes<R: Real>(&self) -> usize {
        let in_use = |group: &OffsetGroup| {
            let words = group.is_tail.by_lanes(lanes::<R>());
            words.into_iter().filter(|&word| word != 0).count()
        };
        self.0.groups.iter().map(in_use).sum()
    }

    /// Whether this slot holds an edge.
    fn holds(&self, slot: usize) -> bool {
        let holds = |group: &OffsetGroup| group.is_tail.get(slot - group.first_slot);
        let mut groups = self.0.groups.iter();
        groups.find(|group| group.has(slot)).is_some_and(holds)
    }

    /// Moves values of edges to the slots of the edges. Ghosts are zero.
    ///
    /// # Panics
    /// If the number of values is not the number of edges.
    pub fn to_slots<R: Real>(&self, per_edge: &[R]) -> Vec<R> {
        assert_eq!(
            per_edge.len(),
            self.0.slot_of_edge.len(),
            "`Graph::to_slots` needs one value for each edge"
        );
        let mut slots = vec![R::zero(); self.0.slots];
        let places = per_edge.iter().zip(&self.0.slot_of_edge);
        for (&value, &slot) in places.filter(|(_, slot)| self.holds(**slot)) {
            slots[slot] = value;
        }
        slots
    }

    /// The edges that are not left out, ordered by slot.
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

    /// The largest offset, which is how far before the first slot a register may read.
    #[inline(always)]
    pub(crate) fn lead(&self) -> usize {
        self.0.groups.last().map_or(0, |group| group.offset)
    }

    #[inline(always)]
    pub(super) fn groups(&self) -> &[OffsetGroup] {
        &self.0.groups
    }
}
