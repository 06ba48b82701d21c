//! Bending stiffness of bars that go on through a node: an angular spring between two edges in
//! line.
//!
//! Off unless the scene asks for it, and then an example of a force that a user would add: a
//! kernel for the law, and this page for who takes part. Nothing of it is differentiated by hand.
//!
//! Two edges of one node that lie in line at the start are a pair. The bar of an edge of
//! stiffness `k` (N/m) whose section has the radius of gyration `r` (m) resists bending by
//! `EI / l = k r^2`; half of each edge acts at the node, one after the other, which makes
//! `2 r^2 k_1 k_2 / (k_1 + k_2)` (N m) for the pair. A void edge bends freely.

use autodiff::{Array, Kernel, Program, Real};

use super::kernels::{Bend, Total};
use crate::lattice::Lattice;

/// Cosine of the angle up to which two edges count as in line: about 8 degrees.
const IN_LINE: f64 = 0.99;
/// Keeps the stiffness of a pair finite where both edges have none, N/m.
const LEAST_STIFFNESS: f64 = 1e-12;
/// Groups whose forces are added in one go.
const AT_ONCE: usize = 4;

/// Three nodes in line, and the edges between them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    nodes: [usize; 3],
    edges: [usize; 2],
}

/// The impulses of a pair of edges on its nodes over a step.
pub(super) struct BentPair {
    pub(super) nodes: [usize; 3],
    /// The impulse on each of them, N s.
    pub(super) impulses: [[f64; 2]; 3],
}

/// The angular spring of a pair of edges.
pub(super) struct AngularSpring {
    /// The node before the middle, the middle one, and the one after.
    pub(super) nodes: [usize; 3],
    /// Angular stiffness, N m.
    pub(super) stiffness: f64,
}

/// The pairs of a lattice, in groups of one shape: in a group the outer nodes are as many places
/// before and after the middle one for every pair, so that whole rows of nodes are moved at once.
/// A slot of a group is a middle node.
#[derive(Clone, Debug)]
pub(super) struct Bending {
    /// Radius of gyration of a bar's section, m.
    radius: f64,
    nodes: usize,
    /// Places from the middle node to the outer ones.
    groups: Vec<[isize; 2]>,
    /// The edges of the pair in every slot, group by group.
    slots: Vec<Option<[usize; 2]>>,
}

impl Bending {
    /// The pairs of a lattice; `None` where bars bend freely or nothing is in line.
    pub(super) fn new(lattice: &Lattice, radius: f64) -> Option<Self> {
        let pairs = if radius > 0.0 {
            pairs(lattice)
        } else {
            Vec::new()
        };
        let shape = |pair: &Pair| {
            let [before, middle, after] = pair.nodes.map(|node| node as isize);
            [before - middle, after - middle]
        };
        let mut groups: Vec<[isize; 2]> = pairs.iter().map(shape).collect();
        groups.sort_unstable();
        groups.dedup();
        let nodes = lattice.nodes();
        let mut slots = vec![None; groups.len() * nodes];
        for pair in &pairs {
            let group = groups
                .binary_search(&shape(pair))
                .expect("every shape has a group");
            slots[group * nodes + pair.nodes[1]] = Some(pair.edges);
        }
        (!pairs.is_empty()).then_some(Self {
            radius,
            nodes,
            groups,
            slots,
        })
    }

    /// The number of slots.
    pub(super) fn slots(&self) -> usize {
        self.slots.len()
    }

    /// The angular stiffness of every slot, N m, from the edges' stiffness.
    pub(super) fn stiffness<R: Real>(&self, edges: &[R]) -> Vec<R> {
        let factor = R::lit(2.0 * self.radius * self.radius);
        let pair = |[a, b]: [usize; 2]| {
            let [a, b] = [edges[a], edges[b]];
            factor * a * b / (a + b + R::lit(LEAST_STIFFNESS))
        };
        let slot = |slot: &Option<[usize; 2]>| slot.map_or(R::zero(), pair);
        self.slots.iter().map(slot).collect()
    }

    /// Adds the pairs' impulses over a step to those of the springs, per node.
    pub(super) fn record<R: Real>(
        &self,
        p: &mut Program<R>,
        stiffness: Array,
        dt: f64,
        [x, y]: [Array; 2],
        impulse: [Array; 2],
    ) -> [Array; 2] {
        let from = [0, 1, 2].map(|role| self.seen_from_slots(role));
        let [before, middle, after] = from
            .each_ref()
            .map(|nodes| [p.gather(x, nodes), p.gather(y, nodes)]);
        let ([ax, ay], [bx, by], [cx, cy]) = (before, middle, after);
        let pulls = p.map(Bend { dt }, [ax, ay, bx, by, cx, cy, stiffness]);
        let mut sums = impulse;
        for role in 0..3 {
            for k in 0..2 {
                sums[k] = self.add(p, sums[k], role, pulls[2 * role + k]);
            }
        }
        sums
    }

    /// The impulses of all pairs over a step, from the edges' stiffness and the nodes' places.
    pub(super) fn impulses(&self, edges: &[f64], dt: f64, x: &[[f64; 2]]) -> Vec<BentPair> {
        let pair = |AngularSpring { nodes, stiffness }| {
            let [[ax, ay], [bx, by], [cx, cy]] = nodes.map(|node| x[node]);
            let pulls = Bend { dt }.eval([ax, ay, bx, by, cx, cy, stiffness]);
            let of_node = |role: usize| [pulls[2 * role], pulls[2 * role + 1]];
            BentPair {
                nodes,
                impulses: [0, 1, 2].map(of_node),
            }
        };
        self.springs(edges).into_iter().map(pair).collect()
    }

    /// The angular springs of all pairs, from the edges' stiffness.
    pub(super) fn springs(&self, edges: &[f64]) -> Vec<AngularSpring> {
        let stiffness = self.stiffness(edges);
        let pair = |slot: usize| {
            self.slots[slot]?;
            let (group, middle) = (self.groups[slot / self.nodes], slot % self.nodes);
            let node = |role: usize| self.place(middle, offset(group, role));
            Some(AngularSpring {
                nodes: [node(0)?, middle, node(2)?],
                stiffness: stiffness[slot],
            })
        };
        (0..self.slots()).filter_map(pair).collect()
    }

    /// For every slot the node that has this role in it: before, middle, after.
    fn seen_from_slots(&self, role: usize) -> Vec<Option<usize>> {
        let group = |&group: &[isize; 2]| {
            (0..self.nodes).map(move |middle| self.place(middle, offset(group, role)))
        };
        self.groups.iter().flat_map(group).collect()
    }

    /// A sum per node, and what the pairs add in which the node has this role.
    fn add<R: Real>(&self, p: &mut Program<R>, sum: Array, role: usize, pull: Array) -> Array {
        let places: Vec<usize> = (0..self.groups.len()).collect();
        places.chunks(AT_ONCE).fold(sum, |sum, chunk| {
            let part = |k: usize| {
                let slot = |node: usize| {
                    let &group = chunk.get(k)?;
                    let middle = self.place(node, -offset(self.groups[group], role))?;
                    Some(group * self.nodes + middle)
                };
                (0..self.nodes).map(slot).collect::<Vec<_>>()
            };
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| p.gather(pull, &part(k)));
            let [sum] = p.map(Total, [sum, a, b, c, d]);
            sum
        })
    }

    /// The node so many places on, where there is one.
    fn place(&self, node: usize, offset: isize) -> Option<usize> {
        node.checked_add_signed(offset)
            .filter(|&place| place < self.nodes)
    }
}

/// Places from a group's middle node to the one of a role.
fn offset([before, after]: [isize; 2], role: usize) -> isize {
    [before, 0, after][role]
}

/// All pairs of edges that share a node and lie in line at the start.
fn pairs(lattice: &Lattice) -> Vec<Pair> {
    let away = |edge: usize, node: usize| {
        let [i, j] = lattice.edges[edge];
        let other = if i == node { j } else { i };
        let [from, to] = [node, other].map(|n| lattice.positions[n]);
        (other, [to[0] - from[0], to[1] - from[1]])
    };
    let mut pairs = Vec::new();
    for node in 0..lattice.nodes() {
        let here = |&edge: &usize| lattice.edges[edge].contains(&node);
        let edges: Vec<usize> = (0..lattice.edges.len()).filter(here).collect();
        for (k, &first) in edges.iter().enumerate() {
            for &second in &edges[k + 1..] {
                let ((before, a), (after, b)) = (away(first, node), away(second, node));
                let dot = a[0] * b[0] + a[1] * b[1];
                if -dot > IN_LINE * a[0].hypot(a[1]) * b[0].hypot(b[1]) {
                    let (mut nodes, mut edges) = ([before, node, after], [first, second]);
                    if before > after {
                        nodes.reverse();
                        edges.reverse();
                    }
                    pairs.push(Pair { nodes, edges });
                }
            }
        }
    }
    pairs
}

#[cfg(test)]
mod tests {
    use super::{Bending, Pair, pairs};
    use crate::lattice::Lattice;

    #[test]
    fn every_line_of_three_nodes_is_a_pair() {
        // Rows and columns have four such lines each, each way of the diagonals four by four.
        assert_eq!(
            pairs(&Lattice::sample(6, 6, 0.0)).len(),
            6 * 4 + 6 * 4 + 2 * 4 * 4
        );
        assert_eq!(
            pairs(&Lattice::sample(6, 6, 15.0)),
            pairs(&Lattice::sample(6, 6, 0.0))
        );
        assert_eq!(pairs(&Lattice::sample(2, 2, 0.0)), []);
        let line = Pair {
            nodes: [0, 1, 2],
            edges: [0, 3],
        };
        assert_eq!(pairs(&Lattice::sample(3, 2, 0.0))[0], line);
    }

    #[test]
    fn nothing_is_recorded_where_bars_bend_freely() {
        assert!(Bending::new(&Lattice::sample(6, 6, 0.0), 0.0).is_none());
        assert!(Bending::new(&Lattice::sample(2, 2, 0.0), 0.01).is_none());
        let bending = Bending::new(&Lattice::sample(6, 6, 0.0), 0.01).unwrap();
        assert_eq!((bending.groups.len(), bending.slots()), (4, 4 * 36));
    }

    #[test]
    fn equal_edges_bend_as_one_bar_and_void_ones_freely() {
        let bending = Bending::new(&Lattice::sample(3, 2, 0.0), 0.01).unwrap();
        let mut stiffness = vec![400.0; 11];
        // The other pair, of the upper row, has one edge without any stiffness.
        *stiffness.last_mut().unwrap() = 0.0;
        let mut pairs = bending.stiffness(&stiffness);
        pairs.retain(|c| *c != 0.0);
        // k r^2; the guard against 0 / 0 takes off a share of 1e-15.
        assert!(pairs.len() == 1 && (pairs[0] - 0.04f64).abs() < 1e-15);
    }
}
