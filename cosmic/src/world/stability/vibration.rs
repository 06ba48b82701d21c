//! The frequencies at which a body vibrates about a state, and bounds on them.
//!
//! The angular frequencies of a lattice are the square roots of the eigenvalues of `M^-1 K`, with the masses `M` and
//! the stiffness matrix `K`. An edge of stiffness `k`, direction `n`, length `l` and target length `l0` adds
//! `k (n n^T + (1 - l0 / l) (I - n n^T))` to `K`. The second part comes from the tension of the edge, which acts against
//! displacements across a stretched edge; it is negative for a compressed edge. Each [force](crate::laws::Force) adds
//! its own part.

use nalgebra::DVector;

use super::lanczos::largest_eigenpair;
use crate::geometry::{Ground, Matrix, Vector};
use crate::lattice::{Body, EdgeVector, Lattice, State};
use crate::laws::{Pose, Stiffness};
use crate::scene::PhysicsSettings;

/// The relative accuracy of the square of a frequency that counts as exact.
const EXACT: f64 = 1e-12;
/// The relative accuracy in lattices of more than `LARGE` nodes. Neighbouring frequencies of a large lattice differ so little
/// that telling them apart takes hundreds of vectors of all nodes.
const BOUND: f64 = 1e-3;
/// The largest number of nodes for which the largest frequency is exact.
const LARGE: usize = 1000;

/// A robot whose forces are linearised about a state.
#[derive(Clone, Debug)]
pub struct Vibration<'a> {
    lattice: &'a Lattice,
    body: &'a Body<f64>,
    /// For each edge, the stiffness along it (`k n n^T`).
    along: Vec<Matrix>,
    /// For each edge, the stiffness across it (`k (1 - l0 / l) (I - n n^T)`), which may be negative.
    across: Vec<Matrix>,
    /// The sum of the stiffness and damping of all forces.
    stiffness: Stiffness,
}

impl<'a> Vibration<'a> {
    /// Linearises the forces on a body with idle actuators. `positions` are those of the nodes in the world's frame
    /// (m). From `physics`, only the forces are used.
    pub fn new(
        lattice: &'a Lattice,
        body: &'a Body<f64>,
        physics: &PhysicsSettings,
        positions: &[Vector<f64>],
    ) -> Self {
        let state = State {
            dimension: lattice.dimension,
            x: positions.to_vec(),
            v: vec![Vector::zero(); positions.len()],
        };
        let pose = Pose::idle(lattice, body, &state, &Ground::from(physics));
        let mut stiffness = Stiffness::none(lattice.nodes(), lattice.edges.len());
        for force in physics.forces_on(lattice) {
            force.stiffen(&pose, &mut stiffness);
        }
        let projector = |&ends: &[usize; 2]| {
            let edge = EdgeVector::of(&pose.state, ends);
            Matrix::square(edge.d / edge.length(lattice.softening()))
        };
        let edges = lattice.edges.iter().map(projector).zip(&stiffness.bars);
        let parts = edges.map(|(projector, bar)| {
            let rest = Matrix::onto(lattice.dimension) + projector * -1.0;
            (projector * bar.along, rest * bar.across)
        });
        let (along, across) = parts.unzip();
        Self {
            lattice,
            body,
            along,
            across,
            stiffness,
        }
    }

    /// A bound on the largest angular frequency `omega`, 1/s, and the node that determines it. `omega^2` is at most the
    /// largest `mu_i + mu_j` of an edge, where `i` and `j` are its nodes. `mu_i` is the square of the largest frequency at
    /// which node `i` vibrates if all other nodes are fixed; the destabilising push of compressed edges is left out. If an
    /// edge determines the bound, the node is the one with the larger `mu_i`.
    pub fn edge_bound(&self) -> (f64, usize) {
        let mu = self.node_frequencies();
        let sum = |&[i, j]: &[usize; 2]| mu[i] + mu[j];
        let ends = self.joined().max_by(|a, b| sum(a).total_cmp(&sum(b)));
        // A node without bars may still vibrate because of forces on single nodes.
        let alone = (0..mu.len()).max_by(|&i, &j| mu[i].total_cmp(&mu[j]).then(j.cmp(&i)));
        let node = match (ends, alone) {
            (Some(ends @ &[i, j]), Some(alone)) if mu[alone] <= sum(ends) => {
                if mu[j] > mu[i] {
                    j
                } else {
                    i
                }
            }
            (_, alone) => alone.unwrap_or(0),
        };
        let sums = self.joined().map(sum);
        let square = mu.iter().copied().chain(sums).fold(0.0, f64::max);
        (square.sqrt(), node)
    }

    /// A bound on the vibrations that only those forces cause that do not act along bars, of robots that vibrate `faster`
    /// times as fast.
    pub(in crate::world) fn off_bars(&self, faster: f64) -> OffBars {
        let mass = &self.body.mass;
        let square = |node: usize| self.stiffness.nodes[node].largest_eigenvalue() / mass[node];
        let node = (0..mass.len()).max_by(|&i, &j| square(i).total_cmp(&square(j)).then(j.cmp(&i)));
        let node = node.unwrap_or(0);
        let damping = self.stiffness.node_damping.iter().zip(mass);
        let damping = damping.fold(0.0, |most: f64, (damping, mass)| most.max(damping / mass));
        OffBars {
            frequency: faster * (2.0 * square(node)).sqrt(),
            damping: faster * faster * damping,
            node,
        }
    }

    /// The largest angular frequency, 1/s, and the node that moves most in that
    /// vibration. The frequency is infinite if stiffness divided by mass overflows. For a lattice of more than a thousand
    /// nodes it is a bound, which is above the largest frequency by at most a thousandth.
    pub fn fastest(&self) -> (f64, usize) {
        match self.body.mass.len() {
            ..=LARGE => self.fastest_within(EXACT),
            _ => self.fastest_within(BOUND),
        }
    }

    /// Like [`fastest`](Self::fastest): a bound on the largest frequency whose square is above its square by at most the
    /// fraction `accuracy`.
    pub fn fastest_within(&self, accuracy: f64) -> (f64, usize) {
        let root: Vec<f64> = self.body.mass.iter().map(|m| m.sqrt().recip()).collect();
        let axes = self.lattice.dimension.count();
        let size = axes * root.len();
        // The start vector must not be orthogonal to the eigenvector. Angles per node with irrational steps break the
        // symmetries of lattices.
        let entry = |k: usize, _| match ((k / axes) as f64, k % axes) {
            (node, 0) => (1.1 + 2.3 * node).sin(),
            (node, 1) => (0.7 + 3.1 * node).cos(),
            (node, _) => (0.4 + 2.7 * node).sin(),
        };
        let start = DVector::from_fn(size, entry);
        match largest_eigenpair(&start, accuracy, |v| self.product(v, &root)) {
            None => (f64::INFINITY, 0),
            Some((square, vector)) => {
                let swing = |i: usize| root[i] * self.of_node(&vector, i).norm();
                let node = (0..root.len()).max_by(|&a, &b| swing(a).total_cmp(&swing(b)));
                let frequency = square.max(0.0).sqrt();
                // The bound from single edges holds whatever vibration the search has found.
                let most = if accuracy > EXACT {
                    self.edge_bound().0
                } else {
                    f64::INFINITY
                };
                (frequency.min(most), node.unwrap_or(0))
            }
        }
    }

    /// Computes `M^-1/2 K M^-1/2 v`. `v` has the components of a vector for each node, and `root` has the entries of `M^-1/2`.
    pub fn product(&self, v: &DVector<f64>, root: &[f64]) -> DVector<f64> {
        let mut product = DVector::zeros(v.len());
        let at = |node: usize| self.of_node(v, node) * root[node];
        let dimension = self.lattice.dimension;
        let mut add = |node: usize, force: Vector<f64>| {
            let parts = dimension.components(force * root[node]);
            for (k, part) in parts.enumerate() {
                product[dimension.count() * node + k] += part;
            }
        };
        let parts = self.along.iter().zip(&self.across);
        for (&[i, j], (along, across)) in self.lattice.edges.iter().zip(parts) {
            let pull = (*along + *across) * (at(j) - at(i));
            add(i, -pull);
            add(j, pull);
        }
        for (i, of_node) in self.stiffness.nodes.iter().enumerate() {
            add(i, *of_node * at(i));
        }
        product
    }

    /// Computes `mu_i` for each node: the largest eigenvalue of a matrix, divided by the node's mass. The matrix is the
    /// sum of the stiffness of the node and of its edges. Of compressed edges, only the stiffness along the edge
    /// counts.
    fn node_frequencies(&self) -> Vec<f64> {
        let mut sums = self.stiffness.nodes.clone();
        let parts = self.along.iter().zip(&self.across);
        for (&[i, j], (along, across)) in self.lattice.edges.iter().zip(parts) {
            let is_stretched = across.trace() > 0.0;
            let part = if is_stretched {
                *along + *across
            } else {
                *along
            };
            sums[i] += part;
            sums[j] += part;
        }
        let nodes = sums.iter().zip(&self.body.mass);
        nodes
            .map(|(sum, mass)| sum.largest_eigenvalue() / mass)
            .collect()
    }

    /// A bound on the rate, 1/s, at which forces that depend on velocities dampen a vibration; 0 without such forces.
    /// The damping by `physics.damping` is not included.
    pub fn damping(&self) -> f64 {
        let mut sums = vec![0.0; self.lattice.nodes()];
        for (&[i, j], damping) in self.lattice.edges.iter().zip(&self.stiffness.bar_damping) {
            sums[i] += 2.0 * damping.abs();
            sums[j] += 2.0 * damping.abs();
        }
        let nodes = sums.iter().zip(&self.stiffness.node_damping);
        let rates = nodes
            .zip(&self.body.mass)
            .map(|((a, b), mass)| (a + b) / mass);
        rates.fold(0.0, f64::max)
    }

    /// The components of `node` in a vector with those of all nodes.
    fn of_node(&self, vector: &DVector<f64>, node: usize) -> Vector<f64> {
        let (dimension, numbers) = (self.lattice.dimension, vector.as_slice());
        dimension.vector(&numbers[dimension.count() * node..][..dimension.count()])
    }

    /// The two nodes of each edge whose stiffness is not 0.
    fn joined(&self) -> impl Iterator<Item = &'a [usize; 2]> {
        let edges = self.lattice.edges.iter().zip(&self.body.stiffness);
        edges.filter(|(_, k)| **k != 0.0).map(|(nodes, _)| nodes)
    }
}

/// Vibrations that are caused by forces off the bars: on single nodes, and between nodes and bars. An implicit step does
/// not solve for these forces.
#[derive(Clone, Copy, Debug)]
pub(in crate::world) struct OffBars {
    /// A bound on the angular frequencies, 1/s.
    pub(in crate::world) frequency: f64,
    /// A bound on the rate at which these forces dampen a vibration, 1/s.
    pub(in crate::world) damping: f64,
    /// The node that determines the bound.
    pub(in crate::world) node: usize,
}
