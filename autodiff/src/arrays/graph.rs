//! Graphs whose edges are stored so that lanes can work on them.
//!
//! Edges are grouped by their offset, the difference of their node numbers. A square lattice with
//! diagonals has four such groups, and within one the ends of neighbouring edges lie side by side:
//! work on edges loads shifted, contiguous data in place of gathering. A group has a **slot** for
//! every node that could be a tail; slots without an edge are ghosts, which take no part.

use std::collections::BTreeSet;
use std::sync::Arc;

use crate::real::Real;
use crate::simd::{WIDEST, lanes};

/// A directed graph, and the slot layout of arrays along its edges.
#[derive(Clone, Debug)]
pub struct Graph(Arc<SlotLayout>);

#[derive(Clone, Debug)]
struct SlotLayout {
    nodes: usize,
    groups: Vec<OffsetGroup>,
    slots: usize,
    slot_of_edge: Vec<usize>,
}

/// An edge by its slot and its nodes.
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
    /// How many slots, a multiple of the widest register's lanes.
    pub(super) len: usize,
    /// For each node, whether it is the tail of an edge, that is, whether its slot holds one; and
    /// whether it is the head of one.
    pub(super) is_tail: Bits,
    pub(super) is_head: Bits,
}

impl OffsetGroup {
    fn has(&self, slot: usize) -> bool {
        (self.first_slot..self.first_slot + self.len).contains(&slot)
    }
}

/// A bit per place, in words as long as the widest register has lanes.
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
    /// Every bit `times` times, one after the other.
    fn repeated(&self, times: usize) -> Self {
        let mut bits = Self::none(self.0.len() * WIDEST * times);
        for place in (0..self.0.len() * WIDEST).filter(|&place| self.get(place)) {
            for copy in 0..times {
                bits.set(place * times + copy);
            }
        }
        bits
    }
    /// The bits register by register, for registers of this many lanes.
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
    /// A graph from its edges `[tail, head]`, `tail < head`. Meant for lattices: memory grows with the
    /// number of nodes times the number of different offsets `head - tail`.
    ///
    /// # Panics
    /// If an edge leaves `0..nodes`, does not ascend, or is given twice.
    pub fn new(nodes: usize, edges: &[[usize; 2]]) -> Self {
        for [i, j] in edges {
            assert!(
                i < j && *j < nodes,
                "edge [{i}, {j}] does not ascend within {nodes} nodes"
            );
        }
        let offsets: BTreeSet<usize> = edges.iter().map(|[i, j]| j - i).collect();
        let mut slots = 0;
        let mut groups = Vec::new();
        for offset in offsets {
            // Whole registers, so that no register has slots of two groups.
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

    /// The same graph without the edges whose mark is true. Nodes, slots and the numbering of edges stay;
    /// the slots of the edges left out become ghosts, and registers of nothing but ghosts cost no work
    /// in [`Program::map_edges`](crate::Program::map_edges).
    ///
    /// # Panics
    /// Unless there is one mark per edge.
    #[must_use]
    pub fn without(&self, marked: &[bool]) -> Self {
        let mut layout = SlotLayout::clone(&self.0);
        assert_eq!(
            marked.len(),
            layout.slot_of_edge.len(),
            "Graph::without needs one mark per edge"
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

    /// `count` copies of this graph, interleaved: node `i` of copy `k` is `i * count + k`, and slots
    /// in the same way. Edges keep the numbering of the first copy.
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

    /// The number of slots, ghosts included: the length of arrays along the edges.
    pub fn slots(&self) -> usize {
        self.0.slots
    }

    /// The slot of every edge, also of those [left out](Graph::without).
    pub fn slot_of_edge(&self) -> &[usize] {
        &self.0.slot_of_edge
    }

    /// The edge of every slot, for [`Program::gather`](crate::Program::gather); `None` for ghosts. Values
    /// that no step changes are better brought [to their slots](Graph::to_slots) once, before the
    /// rollout.
    pub fn edge_of_slot(&self) -> Vec<Option<usize>> {
        let mut edges = vec![None; self.0.slots];
        for (edge, &slot) in self.0.slot_of_edge.iter().enumerate() {
            edges[slot] = self.holds(slot).then_some(edge);
        }
        edges
    }

    /// How many registers of `R` the work on edges takes on this machine: those with an edge in at least
    /// one slot.
    pub fn lanes<R: Real>(&self) -> usize {
        let in_use = |group: &OffsetGroup| {
            let words = group.is_tail.by_lanes(lanes::<R>());
            words.into_iter().filter(|&word| word != 0).count()
        };
        self.0.groups.iter().map(in_use).sum()
    }

    /// Whether an edge is in this slot.
    fn holds(&self, slot: usize) -> bool {
        let holds = |group: &OffsetGroup| group.is_tail.get(slot - group.first_slot);
        let mut groups = self.0.groups.iter();
        groups.find(|group| group.has(slot)).is_some_and(holds)
    }

    /// Values per edge, brought to the slots of the edges; zero in ghosts.
    ///
    /// # Panics
    /// Unless there is one value per edge.
    pub fn to_slots<R: Real>(&self, per_edge: &[R]) -> Vec<R> {
        assert_eq!(
            per_edge.len(),
            self.0.slot_of_edge.len(),
            "Graph::to_slots needs one value per edge"
        );
        let mut slots = vec![R::zero(); self.0.slots];
        let places = per_edge.iter().zip(&self.0.slot_of_edge);
        for (&value, &slot) in places.filter(|(_, slot)| self.holds(**slot)) {
            slots[slot] = value;
        }
        slots
    }

    /// The edges that are not left out, in the order of their slots.
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

    /// The largest offset: how far before the first slot a register may read.
    #[inline(always)]
    pub(crate) fn lead(&self) -> usize {
        self.0.groups.last().map_or(0, |group| group.offset)
    }

    #[inline(always)]
    pub(super) fn groups(&self) -> &[OffsetGroup] {
        &self.0.groups
    }
}
