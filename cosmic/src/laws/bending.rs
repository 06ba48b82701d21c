//! Bending stiffness of bars that continue through a node: an angular spring between two edges in line.
//!
//! The law is off by default. It is also an example of a force that acts neither on single nodes nor along single bars.
//! A kernel computes the impulses on three nodes, and the rest of this file finds those nodes and their edges.
//!
//! Two edges form a pair if they share a node and lie on one line at the start. A bar of stiffness `k` (N/m) whose
//! section has the radius of gyration `r` (m) has the bending stiffness `EI / l = k r^2`. At the node, the halves of
//! both edges act in series, so the pair has the angular stiffness `2 r^2 k_1 k_2 / (k_1 + k_2)` (N m). A void edge
//! bends freely.

use std::any::Any;
use std::sync::Arc;

use autodiff::{AnyProgram, Array, Kernel, Pullback, Real};

use super::force::{AnyForce, Force, Given, Pose, Pull, Step};
use super::stiffness::Stiffness;
use crate::geometry::Vector;
use crate::lattice::{EdgeVector, Lattice};
use crate::settings::Settings;

/// Two edges count as being in line if the cosine of the angle between their directions is larger than this. The
/// largest such angle is about 8 degrees.
const IN_LINE: f64 = 0.99;
/// A stiffness, N/m, that keeps the angular stiffness of a pair finite if both edges have stiffness 0.
const LEAST_STIFFNESS: f64 = 1e-12;
/// The number of arrays of impulses that the kernel [`Total`] adds to a sum.
const AT_ONCE: usize = 4;

/// The force law of bars that resist bending, with its setting.
#[derive(Clone, Debug)]
pub(crate) struct Bending {
    /// Radius of gyration of a bar's section, m: the scene's `physics.bending_radius`.
    pub(crate) radius: f64,
}

impl Settings for Bending {
    fn about(&self) -> &'static str {
        "Bars that continue straight through a node resist bending there."
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
    fn any(&self) -> &dyn Any {
        self
    }
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>> {
        let bars = BentBars::new(lattice, self.radius)?;
        Some(Arc::new(bars))
    }
}

/// An angular spring between two edges, which is at rest if they are in line. If the path over the three nodes turns by
/// the angle `a`, the torque is `c sin(a)` and the energy `c (1 - cos(a))`. It is smooth at every angle; beyond a right
/// angle the torque decreases.
///
/// The kernel computes the impulses on the three nodes (N s) from their coordinates (m) and the stiffness of the two
/// edges (N/m).
#[derive(Clone, Copy, Debug)]
pub struct Bend {
    /// Twice the square of the radius of gyration of a bar's section, m^2.
    pub section: f64,
    /// The [softening](Lattice::softening) of lengths, m^2.
    pub softening: f64,
    /// The time for which the spring pushes the nodes, s.
    pub dt: f64,
}

/// Two edges in line, with the positions of their three nodes and their stiffness. `R` is a number, or an array with a
/// number for each pair.
#[derive(Clone, Copy, Debug)]
pub struct Line<R, const D: usize = 2> {
    /// Positions of the three nodes, m.
    pub nodes: [Vector<R, D>; 3],
    /// Stiffness of the first edge, N/m.
    pub first: R,
    /// Stiffness of the second edge, N/m.
    pub second: R,
}

impl<R: Copy> Line<R> {
    /// The line of eight numbers, the inputs of [`Bend`]: the coordinates of the nodes, then the stiffnesses.
    #[inline(always)]
    pub fn new([x0, y0, x1, y1, x2, y2, first, second]: [R; 8]) -> Self {
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
    /// The direction of the edge that begins at node `from`, as a unit vector, and 1 / length of that edge. `softening`
    /// is in m^2.
    #[inline(always)]
    fn edge(&self, from: usize, softening: f64) -> (Vector<R, D>, R) {
        let edge = self.nodes[from + 1] - self.nodes[from];
        let inverse = edge.softened_norm(softening).recip();
        (edge * inverse, inverse)
    }
}

impl Bend {
    /// The angular stiffness of a pair of edges, N m.
    #[inline(always)]
    pub fn stiffness<R: Real, const D: usize>(&self, line: &Line<R, D>) -> R {
        let (a, b) = (line.first, line.second);
        R::lit(self.section) * a * b / (a + b + R::lit(LEAST_STIFFNESS))
    }

    /// The impulses of the angular spring on the three nodes, N s.
    #[inline(always)]
    pub(super) fn impulses<R: Real, const D: usize>(&self, line: &Line<R, D>) -> [Vector<R, D>; 3] {
        // Not as a map over an array, which is not always inlined.
        let (a, per_a) = line.edge(0, self.softening);
        let (b, per_b) = line.edge(1, self.softening);
        let stiffness = self.stiffness(line) * R::lit(self.dt);
        // A torque on an edge acts as a force across its outer end. The middle node takes the reactions to both forces.
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

/// A kernel that adds five numbers.
#[derive(Clone, Copy, Debug)]
pub struct Total;

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

/// The indices of three nodes in line, and of the two edges between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// The nodes, in line.
    pub nodes: [usize; 3],
    /// The edge between the first two nodes, then the edge between the last two.
    pub edges: [usize; 2],
}

impl Pair {
    /// The shape of a pair: the index of each outer node minus the index of the middle node. Among pairs of the same
    /// shape, a node is the first node of at most one pair, the middle node of at most one, and the last node of at
    /// most one.
    pub fn shape(&self) -> [isize; 2] {
        let [before, middle, after] = self.nodes.map(|node| node as isize);
        [before - middle, after - middle]
    }

    /// The positions and stiffness of this pair in a pose.
    fn line(&self, pose: &Pose) -> Line<f64> {
        let [first, second] = self.edges.map(|edge| pose.body.stiffness[edge]);
        let nodes = self.nodes.map(|node| pose.state.x[node]);
        Line {
            nodes,
            first,
            second,
        }
    }
}

/// The force of bars that resist bending, on one lattice: all pairs of edges, with the setting of the law.
#[derive(Clone, Debug)]
pub struct BentBars {
    /// Radius of gyration of a bar's section, m.
    radius: f64,
    /// The softening of lengths, m^2.
    softening: f64,
    /// The pairs, sorted by shape and then by the middle node, so that gathers of their nodes copy whole rows.
    pub pairs: Vec<Pair>,
}

impl BentBars {
    /// Finds the pairs of a lattice. Returns `None` if the radius is 0 or no edges are in line.
    pub fn new(lattice: &Lattice, radius: f64) -> Option<Self> {
        let mut pairs = pairs(lattice);
        pairs.sort_by_key(|pair| (pair.shape(), pair.nodes[1]));
        let softening = lattice.softening();
        (radius > 0.0 && !pairs.is_empty()).then_some(Self {
            radius,
            softening,
            pairs,
        })
    }

    fn bend(&self, dt: f64) -> Bend {
        Bend {
            section: 2.0 * self.radius * self.radius,
            softening: self.softening,
            dt,
        }
    }

    /// Adds one component of the impulses to `sum`: the impulses on the nodes that have the role `role` in a pair (0
    /// first, 1 middle, 2 last). `pull` has a number for each pair. `sum` and the result have a number for each node.
    fn add(&self, p: &mut AnyProgram, sum: Array, role: usize, pull: Array) -> Array {
        let nodes = sum.len();
        let mut pair = 0;
        let by_shape = self.pairs.chunk_by(|a, b| a.shape() == b.shape());
        let places: Vec<Vec<Option<usize>>> = by_shape
            .map(|pairs| {
                let mut places = vec![None; nodes];
                for of_shape in pairs {
                    places[of_shape.nodes[role]] = Some(pair);
                    pair += 1;
                }
                places
            })
            .collect();
        add_gathered(p, sum, pull, &places)
    }
}

/// Adds numbers to `sum`: for each list of `places`, its places in `x` say which number is added to each entry.
pub(super) fn add_gathered(
    p: &mut AnyProgram,
    sum: Array,
    x: Array,
    places: &[Vec<Option<usize>>],
) -> Array {
    let none = vec![None; sum.len()];
    places.chunks(AT_ONCE).fold(sum, |sum, chunk| {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| p.gather(x, chunk.get(k).unwrap_or(&none)));
        let [sum] = p.map(Total, [sum, a, b, c, d]);
        sum
    })
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
            let places: Vec<_> = self
                .pairs
                .iter()
                .map(|pair| Some(pair.nodes[role]))
                .collect();
            step.nodes.x.map(|x| p.gather(x, &places))
        });
        let [first, second] = [0, 1].map(|k| {
            let slot = |pair: &Pair| Some(step.graph.slot_of_edge()[pair.edges[k]]);
            p.gather(
                step.stiffness,
                &self.pairs.iter().map(slot).collect::<Vec<_>>(),
            )
        });
        let line = Line {
            nodes,
            first,
            second,
        };
        let pulls = p.map(self.bend(step.dt), line.array());
        // A gather that takes no entry gives an array of zeros.
        let none = vec![None; step.graph.nodes()];
        let mut sums = before.unwrap_or_else(|| step.nodes.x.map(|array| p.gather(array, &none)));
        for (role, pull) in pulls.as_chunks().0.iter().enumerate() {
            let pull = Vector::new(*pull);
            sums = sums.zip_with(pull, |sum, pull| self.add(p, sum, role, pull));
        }
        sums
    }

    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        let pull = |pair: &Pair| {
            let role = pair.nodes.iter().position(|&other| other == node)?;
            Some(Pull {
                part: format!("the bending of the bar over nodes {:?}", pair.nodes),
                force: self.bend(1.0).impulses(&pair.line(pose))[role],
            })
        };
        self.pairs.iter().filter_map(pull).collect()
    }

    fn energy(&self, pose: &Pose) -> Option<f64> {
        let energy = |pair: &Pair| {
            let line = pair.line(pose);
            let [(a, _), (b, _)] = [0, 1].map(|from| line.edge(from, self.softening));
            // This is 1 - cos(angle), computed without a difference of numbers close to 1.
            let turned = 0.5 * (a - b).dot(a - b);
            self.bend(1.0).stiffness(&line) * turned
        };
        Some(self.pairs.iter().map(energy).sum())
    }

    /// Adds the matrix `c g g^T` for each pair. Here `c` is the angular stiffness of the pair, and `g . u` is the
    /// change of the angle between its edges if displacements `u` move its three nodes.
    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        for pair in &self.pairs {
            let [before, middle, after] = pair.nodes;
            let length = |ends| EdgeVector::of(&pose.state, ends).length(self.softening);
            let (a, b) = (length([before, middle]), length([middle, after]));
            let whole = EdgeVector::of(&pose.state, [before, after]);
            let across = (whole.d / whole.length(self.softening)).turned_left();
            let g = [1.0 / a, -(1.0 / a + 1.0 / b), 1.0 / b].map(|turn| across * turn);
            stiffness.angle(pair.nodes, g, self.bend(1.0).stiffness(&pair.line(pose)));
        }
    }

    /// The angular stiffness `c` of a pair is at most `2 r^2` times the stiffness of one of its edges. So all pairs
    /// together add at most `12 (r / l)^2` times `of_node` to a squared frequency.
    fn any_design(&self, of_node: f64, shortest: f64, _lightest: f64) -> f64 {
        12.0 * (self.radius / shortest).powi(2) * of_node
    }
}

/// Finds all pairs of edges that share a node and lie in line at the start.
pub fn pairs(lattice: &Lattice) -> Vec<Pair> {
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
