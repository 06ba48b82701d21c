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

use super::force::{AnyForce, Force, Given, Pose, Pull, Step};
use super::stiffness::Stiffness;
use crate::geometry::Vector;
use crate::lattice::{EdgeVector, Lattice, SOFTENING};
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

/// Two edges in line, by numbers or arrays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<R, const D: usize = 2> {
    /// The three nodes, m.
    pub(super) nodes: [Vector<R, D>; 3],
    /// Stiffness of the first edge and of the second, N/m.
    pub(super) first: R,
    pub(super) second: R,
}

impl<R: Copy> Line<R> {
    #[inline(always)]
    fn new([x0, y0, x1, y1, x2, y2, first, second]: [R; 8]) -> Self {
        Self {
            nodes: [
                Vector::new([x0, y0]),
                Vector::new([x1, y1]),
                Vector::new([x2, y2]),
            ],
            first,
            second,
        }
    }

    fn array(self) -> [R; 8] {
        let [[x0, y0], [x1, y1], [x2, y2]] = self.nodes.map(Vector::array);
        [x0, y0, x1, y1, x2, y2, self.first, self.second]
    }
}

impl<R: Real, const D: usize> Line<R, D> {
    /// The unit vector along the edge from a node to the next, and 1 / length.
    #[inline(always)]
    fn edge(&self, from: usize) -> (Vector<R, D>, R) {
        let edge = self.nodes[from + 1] - self.nodes[from];
        let inverse = edge.softened_norm(SOFTENING).recip();
        (edge * inverse, inverse)
    }
}

impl Bend {
    /// The angular stiffness of a pair, N m.
    #[inline(always)]
    fn stiffness<R: Real, const D: usize>(&self, line: &Line<R, D>) -> R {
        let (a, b) = (line.first, line.second);
        R::lit(self.section) * a * b / (a + b + R::lit(LEAST_STIFFNESS))
    }

    /// The impulses on the nodes, N s.
    #[inline(always)]
    pub(super) fn impulses<R: Real, const D: usize>(&self, line: &Line<R, D>) -> [Vector<R, D>; 3] {
        let ((a, per_a), (b, per_b)) = (line.edge(0), line.edge(1));
        let stiffness = self.stiffness(line) * R::lit(self.dt);
        // A torque on an arm is a force across its end; the middle node takes both reactions.
        let first = -a.across(b) * (stiffness * per_a);
        let last = b.across(a) * (stiffness * per_b);
        [first, -(first + last), last]
    }
}

impl Kernel<8, 6> for Bend {
    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; 8]) -> [R; 6] {
        let [first, middle, last] = self.impulses(&Line::new(x));
        let ([fx, fy], [mx, my], [lx, ly]) = (first.array(), middle.array(), last.array());
        [fx, fy, mx, my, lx, ly]
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
    line: Line<f64>,
}

/// Places from the middle node of a pair to the outer ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Shape {
    before: isize,
    after: isize,
}

impl Shape {
    /// Places from the middle node to the one of a role: before, middle, after.
    fn offset(self, role: usize) -> isize {
        [self.before, 0, self.after][role]
    }
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
    groups: Vec<Shape>,
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
            Shape {
                before: before - middle,
                after: after - middle,
            }
        };
        let mut groups: Vec<Shape> = pairs.iter().map(shape).collect();
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
            let node = |role: usize| self.place(middle, group.offset(role));
            let nodes = [node(0)?, middle, node(2)?];
            let [first, second] = (*edges)?.map(|edge| pose.body.stiffness[edge]);
            let line = Line {
                nodes: nodes.map(|node| pose.state.x[node]),
                first,
                second,
            };
            Some(PosedPair { nodes, line })
        };
        self.slots.iter().enumerate().filter_map(pair).collect()
    }

    /// For every slot the node that has this role in it: before, middle, after.
    fn seen_from_slots(&self, role: usize) -> Vec<Option<usize>> {
        let group = |&group: &Shape| {
            (0..self.nodes).map(move |middle| self.place(middle, group.offset(role)))
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
                    let middle = self.place(node, -self.groups[group].offset(role))?;
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
        _: &Given<Array>,
        before: Option<Vector<Array>>,
    ) -> Vector<Array> {
        let nodes = [0, 1, 2].map(|role| {
            let seen = self.seen_from_slots(role);
            step.nodes.x.map(|x| p.gather(x, &seen))
        });
        let mut stiffness = |k: usize| {
            let slot =
                |pair: &Option<[usize; 2]>| pair.map(|edges| step.graph.slot_of_edge()[edges[k]]);
            let slots: Vec<_> = self.slots.iter().map(slot).collect();
            p.gather(step.stiffness, &slots)
        };
        let (first, second) = (stiffness(0), stiffness(1));
        let line = Line {
            nodes,
            first,
            second,
        };
        let pulls = p.map(self.bend(step.dt), line.array());
        // Without forces before it, a gather of no entry is zero.
        let none = vec![None; self.nodes];
        let mut sums = before.unwrap_or_else(|| step.nodes.x.map(|array| p.gather(array, &none)));
        for (role, pull) in pulls.as_chunks().0.iter().enumerate() {
            let pull = Vector::new(*pull);
            sums = sums.zip_with(pull, |sum, pull| self.add(p, sum, role, pull));
        }
        sums
    }

    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        let pull = |PosedPair { nodes, line }: PosedPair| {
            let role = nodes.iter().position(|&other| other == node)?;
            Some(Pull {
                part: format!("the bending of the bar over nodes {nodes:?}"),
                force: self.bend(1.0).impulses(&line)[role],
            })
        };
        self.pairs(pose).into_iter().filter_map(pull).collect()
    }

    fn energy(&self, pose: &Pose) -> Option<f64> {
        let energy = |PosedPair { line, .. }: PosedPair| {
            let ((a, _), (b, _)) = (line.edge(0), line.edge(1));
            // 1 - cos(a), without taking numbers near 1 from each other.
            let turned = 0.5 * (a - b).dot(a - b);
            self.bend(1.0).stiffness(&line) * turned
        };
        Some(self.pairs(pose).into_iter().map(energy).sum())
    }

    /// Two edges in line add `c g g^T`, where `g . u` is the angle between them by displacements `u` of
    /// their three nodes.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        for PosedPair { nodes, line } in self.pairs(pose) {
            let [before, middle, after] = nodes;
            let length = |ends| EdgeVector::of(&pose.state, ends).length();
            let (a, b) = (length([before, middle]), length([middle, after]));
            let whole = EdgeVector::of(&pose.state, [before, after]);
            let across = (whole.d / whole.length()).turned_left();
            let g = [1.0 / a, -(1.0 / a + 1.0 / b), 1.0 / b].map(|turn| across * turn);
            stiffness.angle(nodes, g, self.bend(1.0).stiffness(&line));
        }
    }

    /// A pair's `c` is at most `2 r^2` times the stiffness of an edge at the node that it pulls on, which
    /// makes at most `12 (r / l)^2` times the square of that node's own frequency.
    fn any_design(&self, of_node: f64, shortest: f64) -> f64 {
        12.0 * (self.radius / shortest).powi(2) * of_node
    }
}

/// All pairs of edges that share a node and lie in line at the start.
fn pairs(lattice: &Lattice) -> Vec<Pair> {
    let away = |edge: usize, node: usize| {
        let [i, j] = lattice.edges[edge];
        let other = if i == node { j } else { i };
        (other, lattice.positions[other] - lattice.positions[node])
    };
    let mut pairs = Vec::new();
    for node in 0..lattice.nodes() {
        let here = |&edge: &usize| lattice.edges[edge].contains(&node);
        let edges: Vec<usize> = (0..lattice.edges.len()).filter(here).collect();
        for (k, &first) in edges.iter().enumerate() {
            for &second in &edges[k + 1..] {
                let ((before, a), (after, b)) = (away(first, node), away(second, node));
                if -a.dot(b) > IN_LINE * a.norm() * b.norm() {
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
    use super::{Bend, BentBars, Line, Pair, pairs};
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
        let stiffness = |first: f64, second: f64| {
            bend.stiffness(&Line::new([0.0, 0.0, 0.1, 0.0, 0.2, 0.0, first, second]))
        };
        assert!((stiffness(400.0, 400.0) - 0.04).abs() < 1e-15);
        assert_eq!([stiffness(400.0, 0.0), stiffness(0.0, 0.0)], [0.0; 2]);
    }
}
