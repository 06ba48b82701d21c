//! The layers into which bars are stacked. Two bars in the same layer do not touch.

use super::member::Member;
use cosmic::geometry::Vector;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Bars stacked in layers, which are numbered from 0.
pub struct Stack {
    /// The layer of each bar.
    pub of_member: Vec<usize>,
    /// For each node at which a bar ends, the lowest and the highest layer of its bars, as a range.
    pub at_node: BTreeMap<usize, RangeInclusive<usize>>,
    /// `None` if the stack can be built. Otherwise the index of an edge and the index of a node: the bar of this edge
    /// lies across the pin of this node.
    pub blocked: Option<[usize; 2]>,
}

impl Stack {
    /// Assigns bars to layers. Bars are taken in the order of their conflicts, the bar with the most conflicts first
    /// (D. Welsh and M. Powell, 1967), and each gets the lowest layer in which it has no conflict. A bar that passes a
    /// node within `reach` (mm) without ending there goes on top of all others, above the node's pin.
    pub fn new(
        members: &[Member],
        reach: f64,
        conflict: impl Fn(&Member, &Member) -> bool,
    ) -> Self {
        let conflicts = |a: &Member| -> Vec<usize> {
            let others = members.iter().enumerate();
            let with = others.filter(|(_, b)| a.edge != b.edge && conflict(a, b));
            with.map(|(k, _)| k).collect()
        };
        let conflicts: Vec<Vec<usize>> = members.iter().map(conflicts).collect();
        let crossings = crossings(members, reach);
        let mut order: Vec<usize> = (0..members.len()).collect();
        order.sort_by_key(|&k| {
            let crosses = !crossings[k].is_empty();
            (crosses, std::cmp::Reverse(conflicts[k].len()), k)
        });
        let mut layers = vec![None; members.len()];
        let mut floor = 0;
        let mut used = 0;
        for k in order {
            if !crossings[k].is_empty() && floor == 0 {
                floor = used;
            }
            let is_free = |layer: &usize| conflicts[k].iter().all(|&c| layers[c] != Some(*layer));
            // The search always finds a layer, because a bar has finitely many conflicts and `floor..` has no end.
            let layer = (floor..).find(is_free).unwrap_or(floor);
            layers[k] = Some(layer);
            used = used.max(layer + 1);
        }
        let of_member: Vec<usize> = layers.into_iter().flatten().collect();
        let at_node = spans(members, &of_member);
        let is_blocked = |k: usize| {
            let node = (crossings[k].iter()).find(|node| at_node[node].contains(&of_member[k]))?;
            Some([members[k].edge, *node])
        };
        let blocked = (0..members.len()).find_map(is_blocked);
        Self {
            of_member,
            at_node,
            blocked,
        }
    }

    /// Returns the number of layers.
    pub fn height(&self) -> usize {
        self.of_member.iter().max().map_or(0, |top| top + 1)
    }
}

/// Returns the nodes at which a bar ends, with their positions.
pub(super) fn joints(members: &[Member]) -> BTreeMap<usize, Vector<f64>> {
    let ends = |m: &Member| [(m.nodes[0], m.axis.from), (m.nodes[1], m.axis.to)];
    members.iter().flat_map(ends).collect()
}

/// Returns, for each bar, the nodes that it passes. A bar passes a node that is nearer to it than `reach` and is not
/// one of its ends.
fn crossings(members: &[Member], reach: f64) -> Vec<Vec<usize>> {
    let joints = joints(members);
    let of_member = |m: &Member| {
        let others = joints.iter().filter(|(node, _)| !m.nodes.contains(node));
        let near = others.filter(|(_, place)| m.axis.distance_to(**place) < reach);
        near.map(|(node, _)| *node).collect()
    };
    members.iter().map(of_member).collect()
}

fn spans(members: &[Member], layers: &[usize]) -> BTreeMap<usize, RangeInclusive<usize>> {
    let mut spans = BTreeMap::<usize, RangeInclusive<usize>>::new();
    for (member, &layer) in members.iter().zip(layers) {
        for node in member.nodes {
            let span = spans.entry(node).or_insert(layer..=layer);
            *span = layer.min(*span.start())..=layer.max(*span.end());
        }
    }
    spans
}
