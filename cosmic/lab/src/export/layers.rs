//! The layers into which bars are stacked. Two bars in the same layer do not touch.

use super::member::Member;
use cosmic::geometry::Vector;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Bars stacked in layers, which are numbered from 0.
pub(super) struct Stack {
    /// The layer of each bar.
    pub(super) of_member: Vec<usize>,
    /// For each node at which a bar ends, the lowest and the highest layer of its bars, as a range.
    pub(super) at_node: BTreeMap<usize, RangeInclusive<usize>>,
    /// `None` if the stack can be built. Otherwise the index of an edge and the index of a node: the bar of this edge
    /// lies across the pin of this node.
    pub(super) blocked: Option<[usize; 2]>,
}

impl Stack {
    /// Assigns bars to layers. Bars are taken in the order of their conflicts, the bar with the most conflicts first
    /// (D. Welsh and M. Powell, 1967), and each gets the lowest layer in which it has no conflict. A bar that passes a
    /// node within `reach` (mm) without ending there goes on top of all others, above the node's pin.
    pub(super) fn new(
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
    pub(super) fn height(&self) -> usize {
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

#[cfg(test)]
mod tests {
    use super::Stack;
    use crate::export::member::{Member, sample};

    fn stack(members: &[Member]) -> Stack {
        Stack::new(members, 2.0, |a, b| a.distance(b) < 1.0)
    }

    /// Returns bars between nodes that are in a row, 10 mm apart.
    fn in_a_row(edges: &[[usize; 2]]) -> Vec<Member> {
        let place = |node: usize| [10.0 * node as f64, 0.0];
        let bars = edges.iter().enumerate();
        bars.map(|(k, nodes)| sample(k, *nodes, nodes.map(place)))
            .collect()
    }

    #[test]
    fn bars_that_touch_are_in_different_layers_and_few_are_used() {
        let corners = [[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0]];
        let edges = [[0, 1], [0, 2], [1, 3], [2, 3], [0, 3], [1, 2]];
        let bars: Vec<Member> = (edges.iter().enumerate())
            .map(|(k, nodes)| sample(k, *nodes, nodes.map(|n| corners[n])))
            .collect();
        let stack = stack(&bars);
        for (k, a) in bars.iter().enumerate() {
            for (l, b) in bars.iter().enumerate().skip(k + 1) {
                assert!(a.distance(b) >= 1.0 || stack.of_member[k] != stack.of_member[l]);
            }
        }
        // Opposite sides of the square share a layer; each diagonal touches all other bars.
        assert_eq!((stack.height(), stack.blocked), (4, None));
        assert!(stack.at_node.values().all(|span| span.end() > span.start()));
    }

    #[test]
    fn a_bar_across_a_node_is_on_top_and_two_that_block_each_other_are_reported() {
        let stack_of = |edges: &[[usize; 2]]| stack(&in_a_row(edges));
        let one = stack_of(&[[0, 2], [0, 1], [1, 2], [2, 3]]);
        assert_eq!((one.of_member[0], one.blocked), (2, None));
        // Whichever of the first two bars is on top, the pin at its end goes through the other one.
        let two = stack_of(&[[0, 2], [1, 3], [0, 1], [1, 2], [2, 3]]);
        assert!(two.blocked.is_some());
    }
}
