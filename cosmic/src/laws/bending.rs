//! Bending stiffness of bars that go on through a node: an angular spring between two edges in
//! line.
//!
//! Off unless the scene asks for it, and then an example of a force that is neither one on every node
//! nor one along every bar: a kernel for the law, and this page for who takes part. Nothing of it is
//! differentiated by hand.
//!
//! Two edges of one node that lie in line at the start are a pair. The bar of an edge of
//! stiffness `k` (N/m) whose section has the radius of gyration `r` (m) resists bending by
//! `EI / l = k r^2`; half of each edge acts at the node, one after the other, which makes
//! `2 r^2 k_1 k_2 / (k_1 + k_2)` (N m) for the pair. A void edge bends freely.

use std::sync::Arc;

use autodiff::{AnyProgram, Array, Kernel, Pullback, Real};

use super::force::{AnyForce, Force, Pose, Pull, Step};
use super::stiffness::Stiffness;
use crate::lattice::{Lattice, SOFTENING, length};
use crate::settings::Settings;

/// Cosine of the angle up to which two edges count as in line: about 8 degrees.
const IN_LINE: f64 = 0.99;
/// Keeps the stiffness of a pair finite where both edges have none, N/m.
const LEAST_STIFFNESS: f64 = 1e-12;
/// Groups whose forces are added in one go.
const AT_ONCE: usize = 4;

/// Bars that resist bending.
#[derive(Clone, Debug)]
pub(crate) struct Bending {
    /// Radius of gyration of a bar's section, m: the scene's `physics.bending_radius`.
    pub(crate) radius: f64,
}

impl Settings for Bending {
    fn about(&self) -> &'static str {
        "Bars in line resist bending at the node between them."
    }
}

impl AnyForce for Bending {
    fn name(&self) -> &'static str {
        "bending"
    }
    fn settings(&mut self) -> &mut dyn Settings {
        self
    }
    fn boxed(&self) -> Box<dyn AnyForce> {
        Box::new(self.clone())
    }
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>> {
        let bars = BentBars::new(lattice, self.radius)?;
        Some(Arc::new(bars))
    }
}

/// An angular spring between two edges that are in line when it is at ease: a torque `c sin(a)`
/// where the path over the three nodes turns by the angle `a`, of the energy `c (1 - cos(a))`.
/// Smooth at every angle; the resistance fades beyond a right one.
///
/// From the three nodes' coordinates (m) and the stiffness of the two edges (N/m) to the impulses on
/// them (N s).
#[derive(Clone, Copy, Debug)]
pub(super) struct Bend {
    /// `2 r^2`, m^2.
    pub(super) section: f64,
    /// For how long it pushes, s.
    pub(super) dt: f64,
}

impl Bend {
    /// The angular stiffness of a pair, N m.
    #[inline(always)]
    fn stiffness<R: Real>(&self, [a, b]: [R; 2]) -> R {
        R::lit(self.section) * a * b / (a + b + R::lit(LEAST_STIFFNESS))
    }
}

impl Kernel<8, 6> for Bend {
    #[inline(always)]
    fn eval<R: Real>(&self, [x0, y0, x1, y1, x2, y2, first, second]: [R; 8]) -> [R; 6] {
        let unit = |dx: R, dy: R| {
            let inverse = dx.fma(dx, dy.fma(dy, R::lit(SOFTENING))).sqrt().recip();
            (dx * inverse, dy * inverse, inverse)
        };
        let (ax, ay, per_a) = unit(x1 - x0, y1 - y0);
        let (bx, by, per_b) = unit(x2 - x1, y2 - y1);
        let stiffness = self.stiffness([first, second]);
        let torque = stiffness * (ax * by - ay * bx) * R::lit(self.dt);
        // A torque on an arm is a force across its end; the middle node takes both reactions.
        let (first, last) = (torque * per_a, torque * per_b);
        let [fx, fy, lx, ly] = [first * ay, -(first * ax), last * by, -(last * bx)];
        [fx, fy, -(fx + lx), -(fy + ly), lx, ly]
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 8, 6, M>) -> [[R; 8]; M] {
        self.emitted_vjp(at)
    }
}

/// A sum of five.
#[derive(Clone, Copy, Debug)]
pub(super) struct Total;

impl Kernel<5, 1> for Total {
    #[inline(always)]
    fn eval<R: Real>(&self, [a, b, c, d, e]: [R; 5]) -> [R; 1] {
        [a + b + (c + d) + e]
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 5, 1, M>) -> [[R; 5]; M] {
        self.emitted_vjp(at)
    }
}

/// Three nodes in line, and the edges between them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    nodes: [usize; 3],
    edges: [usize; 2],
}

/// A pair of edges of a pose.
struct PosedPair {
    nodes: [usize; 3],
    /// Coordinates of the nodes, m.
    x: [[f64; 2]; 3],
    /// Stiffness of the edges, N/m.
    stiffness: [f64; 2],
}

/// The pairs of a lattice, in groups of one shape: in a group the outer nodes are as many places
/// before and after the middle one for every pair, so that whole rows of nodes are moved at once.
/// A slot of a group is a middle node.
#[derive(Clone, Debug)]
struct BentBars {
    /// Radius of gyration of a bar's section, m.
    radius: f64,
    nodes: usize,
    /// Places from the middle node to the outer ones.
    groups: Vec<[isize; 2]>,
    /// The edges of the pair in every slot, group by group.
    slots: Vec<Option<[usize; 2]>>,
}

impl BentBars {
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

    fn bend(&self, dt: f64) -> Bend {
        Bend {
            section: 2.0 * self.radius * self.radius,
            dt,
        }
    }

    /// All pairs of a pose.
    fn pairs(&self, pose: &Pose) -> Vec<PosedPair> {
        let pair = |(slot, edges): (usize, &Option<[usize; 2]>)| {
            let (group, middle) = (self.groups[slot / self.nodes], slot % self.nodes);
            let node = |role: usize| self.place(middle, offset(group, role));
            let nodes = [node(0)?, middle, node(2)?];
            Some(PosedPair {
                nodes,
                x: nodes.map(|node| pose.state.x[node]),
                stiffness: (*edges)?.map(|edge| pose.body.stiffness[edge]),
            })
        };
        self.slots.iter().enumerate().filter_map(pair).collect()
    }

    /// For every slot the node that has this role in it: before, middle, after.
    fn seen_from_slots(&self, role: usize) -> Vec<Option<usize>> {
        let group = |&group: &[isize; 2]| {
            (0..self.nodes).map(move |middle| self.place(middle, offset(group, role)))
        };
        self.groups.iter().flat_map(group).collect()
    }

    /// A sum per node, and what the pairs add in which the node has this role.
    fn add(&self, p: &mut AnyProgram, sum: Array, role: usize, pull: Array) -> Array {
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

impl Force for BentBars {
    fn record(
        &self,
        p: &mut AnyProgram,
        step: &Step,
        _: &[Array],
        before: Option<[Array; 2]>,
    ) -> [Array; 2] {
        let [x, y] = step.x;
        let from = [0, 1, 2].map(|role| self.seen_from_slots(role));
        let [before_it, middle, after] = from
            .each_ref()
            .map(|nodes| [p.gather(x, nodes), p.gather(y, nodes)]);
        let ([ax, ay], [bx, by], [cx, cy]) = (before_it, middle, after);
        let [first, second] = [0, 1].map(|k| {
            let slot =
                |pair: &Option<[usize; 2]>| pair.map(|edges| step.graph.slot_of_edge()[edges[k]]);
            let slots: Vec<_> = self.slots.iter().map(slot).collect();
            p.gather(step.stiffness, &slots)
        });
        let nodes = [ax, ay, bx, by, cx, cy, first, second];
        let pulls = p.map(self.bend(step.dt), nodes);
        // Without forces before it, a gather of no entry is zero.
        let none = vec![None; self.nodes];
        let mut sums = before.unwrap_or_else(|| [x, y].map(|array| p.gather(array, &none)));
        for role in 0..3 {
            for k in 0..2 {
                sums[k] = self.add(p, sums[k], role, pulls[2 * role + k]);
            }
        }
        sums
    }

    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        let pull = |PosedPair {
                        nodes,
                        x,
                        stiffness,
                    }: PosedPair| {
            let role = nodes.iter().position(|&other| other == node)?;
            let ([[ax, ay], [bx, by], [cx, cy]], [first, second]) = (x, stiffness);
            let pulls = self.bend(1.0).eval([ax, ay, bx, by, cx, cy, first, second]);
            Some(Pull {
                part: format!("the bending of the bar over nodes {nodes:?}"),
                force: [pulls[2 * role], pulls[2 * role + 1]],
            })
        };
        self.pairs(pose).into_iter().filter_map(pull).collect()
    }

    fn energy(&self, pose: &Pose) -> Option<f64> {
        let energy = |pair: PosedPair| {
            let [before, middle, after] = pair.nodes;
            let [ax, ay] = direction(&pose.state.x, [before, middle]);
            let [bx, by] = direction(&pose.state.x, [middle, after]);
            // 1 - cos(a), without taking numbers near 1 from each other.
            let turned = 0.5 * ((ax - bx) * (ax - bx) + (ay - by) * (ay - by));
            self.bend(1.0).stiffness(pair.stiffness) * turned
        };
        Some(self.pairs(pose).into_iter().map(energy).sum())
    }

    /// Two edges in line add `c g g^T`, where `g . u` is the angle between them by displacements `u` of
    /// their three nodes.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        for pair in self.pairs(pose) {
            let [before, middle, after] = pair.nodes;
            let x = &pose.state.x;
            let [a, b, bar] =
                [[before, middle], [middle, after], [before, after]].map(|e| length(x, e));
            let across = [
                -(x[after][1] - x[before][1]) / bar,
                (x[after][0] - x[before][0]) / bar,
            ];
            let g = [1.0 / a, -(1.0 / a + 1.0 / b), 1.0 / b].map(|turn| across.map(|c| c * turn));
            stiffness.angle(pair.nodes, g, self.bend(1.0).stiffness(pair.stiffness));
        }
    }

    /// A pair's `c` is at most `2 r^2` times the stiffness of an edge at the node that it pulls on, which
    /// makes at most `12 (r / l)^2` times the square of that node's own frequency.
    fn any_design(&self, of_node: f64, shortest: f64) -> f64 {
        12.0 * (self.radius / shortest).powi(2) * of_node
    }
}

/// The unit vector along an edge.
fn direction(x: &[[f64; 2]], [i, j]: [usize; 2]) -> [f64; 2] {
    let length = length(x, [i, j]);
    [0, 1].map(|k| (x[j][k] - x[i][k]) / length)
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
    use super::{Bend, BentBars, Pair, pairs};
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
        assert!(BentBars::new(&Lattice::sample(6, 6, 0.0), 0.0).is_none());
        assert!(BentBars::new(&Lattice::sample(2, 2, 0.0), 0.01).is_none());
        let bending = BentBars::new(&Lattice::sample(6, 6, 0.0), 0.01).unwrap();
        assert_eq!((bending.groups.len(), bending.slots.len()), (4, 4 * 36));
    }

    #[test]
    fn equal_edges_bend_as_one_bar_and_void_ones_freely() {
        let bend = Bend {
            section: 2.0 * 0.01 * 0.01,
            dt: 1.0,
        };
        // k r^2; the guard against 0 / 0 takes off a share of 1e-15.
        assert!((bend.stiffness([400.0, 400.0]) - 0.04f64).abs() < 1e-15);
        assert_eq!(
            [[400.0, 0.0], [0.0, 0.0]].map(|k| bend.stiffness(k)),
            [0.0; 2]
        );
    }
}
