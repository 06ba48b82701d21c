//! The frequencies of a body about a state, and bounds on them.
//!
//! The frequencies of a lattice at rest are the roots of the eigenvalues of `M^-1 K`, where an edge
//! of direction `n`, length `l` and target length `l0` adds
//! `k (n n^T + (1 - l0 / l) (I - n n^T))` to `K`: the second part, the pull across a stretched
//! edge, is negative for a compressed one. Every [force](crate::laws::Force) says what it adds.

use nalgebra::{DVector, Matrix2, Vector2};

use super::lanczos::largest_eigenpair;
use crate::lattice::{Body, Lattice, State, length};
use crate::laws::{Angle, Pose, Stiffness};
use crate::scene::PhysicsSettings;

/// A robot linearised about a state in which it pulls on its nodes as the springs there do.
#[derive(Clone, Debug)]
pub struct Vibration<'a> {
    lattice: &'a Lattice,
    body: &'a Body<f64>,
    /// Per edge, the stiffness along it (`k n n^T`).
    along: Vec<Matrix2<f64>>,
    /// Per edge, the stiffness across it (`k (1 - l0 / l) (I - n n^T)`), of either sign.
    across: Vec<Matrix2<f64>>,
    /// All that forces add at the pose.
    stiffness: Stiffness,
}

impl<'a> Vibration<'a> {
    /// A body whose nodes are at these positions (m, either frame), its actuators idle. Of the
    /// physics the forces count.
    pub fn new(
        lattice: &'a Lattice,
        body: &'a Body<f64>,
        physics: &PhysicsSettings,
        positions: &[[f64; 2]],
    ) -> Self {
        let state = State {
            x: positions.to_vec(),
            v: vec![[0.0; 2]; positions.len()],
        };
        let pose = Pose {
            lattice,
            body,
            state: &state,
            activation: &[],
            time: 0.0,
        };
        let mut stiffness = Stiffness::none(lattice.nodes(), lattice.edges.len());
        for force in physics.forces_on(lattice) {
            force.stiffen(&pose, &mut stiffness);
        }
        let edge = |(&[i, j], &[along, across]): (&[usize; 2], &[f64; 2])| {
            let [tail, head] = [i, j].map(|node| Vector2::from(positions[node]));
            let direction = (head - tail) / length(positions, [i, j]);
            let projector = direction * direction.transpose();
            (
                along * projector,
                across * (Matrix2::identity() - projector),
            )
        };
        let edges = lattice.edges.iter().zip(&stiffness.bars);
        let (along, across) = edges.map(edge).unzip();
        Self {
            lattice,
            body,
            along,
            across,
            stiffness,
        }
    }

    /// A bound on the largest angular frequency, 1/s, from the nodes that an edge joins:
    /// `omega^2 <= max over edges (mu_i + mu_j)`, where `mu_i` is the largest frequency squared
    /// of node `i` alone among fixed neighbours, compressed edges counted without their push. Bars
    /// add at most the largest `nu_i`, where `nu_i` comes of `c |g_i| (|g_i| + |g_j| + |g_k|)`
    /// across each bar at node `i`.
    pub fn edge_bound(&self) -> f64 {
        let of_edges = self.over_edges(&self.node_frequencies());
        of_edges.hypot(self.of_bars().0)
    }

    /// Where the [bound](Vibration::edge_bound) comes from: of the two nodes of its edge the one
    /// that would swing faster alone.
    pub fn bounding_node(&self) -> usize {
        let mu = self.node_frequencies();
        let (of_bars, node) = self.of_bars();
        if of_bars > self.over_edges(&mu) {
            return node;
        }
        let sum = |&[i, j]: &[usize; 2]| mu[i] + mu[j];
        let ends = self.joined().max_by(|a, b| sum(a).total_cmp(&sum(b)));
        let alone = (0..mu.len()).max_by(|&i, &j| mu[i].total_cmp(&mu[j]).then(j.cmp(&i)));
        match (ends, alone) {
            (Some(ends @ &[i, j]), Some(alone)) if mu[alone] <= sum(ends) => {
                if mu[j] > mu[i] {
                    j
                } else {
                    i
                }
            }
            (_, alone) => alone.unwrap_or(0),
        }
    }

    /// A coarser bound from single nodes: `omega^2 <= 2 max over nodes mu_i`, and the part of bars.
    pub fn node_bound(&self) -> f64 {
        let mu = self.node_frequencies();
        let of_edges = (2.0 * mu.into_iter().fold(0.0, f64::max)).sqrt();
        of_edges.hypot(self.of_bars().0)
    }

    /// The largest angular frequency, 1/s.
    pub fn largest_frequency(&self) -> f64 {
        self.fastest().0
    }

    /// The [largest angular frequency](Vibration::largest_frequency), 1/s, and the node that
    /// moves most in that vibration. Infinite where stiffness over mass overflows.
    pub fn fastest(&self) -> (f64, usize) {
        let root: Vec<f64> = self.body.mass.iter().map(|m| m.sqrt().recip()).collect();
        let size = 2 * root.len();
        // Any start does that is not orthogonal to the vector sought; two irrational turns a
        // node are in no symmetric lattice's favour.
        let entry = |k: usize, _| match ((k / 2) as f64, k % 2) {
            (node, 0) => (1.1 + 2.3 * node).sin(),
            (node, _) => (0.7 + 3.1 * node).cos(),
        };
        let start = DVector::from_fn(size, entry);
        match largest_eigenpair(&start, |v| self.product(v, &root)) {
            None => (f64::INFINITY, 0),
            Some((square, vector)) => {
                let swing = |i: usize| root[i] * vector[2 * i].hypot(vector[2 * i + 1]);
                let node = (0..root.len()).max_by(|&a, &b| swing(a).total_cmp(&swing(b)));
                (square.max(0.0).sqrt(), node.unwrap_or(0))
            }
        }
    }

    /// `M^-1/2 K M^-1/2 v`, two entries a node.
    fn product(&self, v: &DVector<f64>, root: &[f64]) -> DVector<f64> {
        let mut product = DVector::zeros(v.len());
        let at = |node: usize| root[node] * Vector2::new(v[2 * node], v[2 * node + 1]);
        let mut add = |node: usize, force: Vector2<f64>| {
            let mut rows = product.fixed_rows_mut::<2>(2 * node);
            rows += root[node] * force;
        };
        let parts = self.along.iter().zip(&self.across);
        for (&[i, j], (along, across)) in self.lattice.edges.iter().zip(parts) {
            let pull = (along + across) * (at(j) - at(i));
            add(i, -pull);
            add(j, pull);
        }
        for Angle { nodes, by } in &self.stiffness.angles {
            let by = by.map(Vector2::from);
            let angle: f64 = nodes.iter().zip(by).map(|(&i, g)| g.dot(&at(i))).sum();
            for (&i, g) in nodes.iter().zip(by) {
                add(i, g * angle);
            }
        }
        for (i, of_node) in self.stiffness.nodes.iter().enumerate() {
            add(i, Matrix2::from(*of_node) * at(i));
        }
        product
    }

    /// The largest frequency that bars alone have at most, 1/s, and the node that it comes from.
    fn of_bars(&self) -> (f64, usize) {
        let mut sums = vec![Matrix2::zeros(); self.lattice.nodes()];
        for Angle { nodes, by } in &self.stiffness.angles {
            let by = by.map(Vector2::from);
            let all: f64 = by.iter().map(|g| g.norm()).sum();
            for (&i, g) in nodes.iter().zip(by).filter(|(_, g)| g.norm() > 0.0) {
                sums[i] += g * g.transpose() * (all / g.norm());
            }
        }
        let nodes = sums.into_iter().zip(&self.body.mass).enumerate();
        let alone = nodes.map(|(i, (sum, mass))| (largest_eigenvalue(&sum) / mass, i));
        let (square, node) = alone.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, 0));
        (square.sqrt(), node)
    }

    /// Per node the largest eigenvalue of its own and of its edges' stiffness over its mass, compressed
    /// edges counted along themselves alone.
    fn node_frequencies(&self) -> Vec<f64> {
        let of_nodes = self.stiffness.nodes.iter();
        let mut sums: Vec<Matrix2<f64>> = of_nodes.map(|&of_node| of_node.into()).collect();
        let parts = self.along.iter().zip(&self.across);
        for (&[i, j], (along, across)) in self.lattice.edges.iter().zip(parts) {
            let is_stretched = across.trace() > 0.0;
            let part = if is_stretched { along + across } else { *along };
            sums[i] += part;
            sums[j] += part;
        }
        let nodes = sums.iter().zip(&self.body.mass);
        nodes
            .map(|(sum, mass)| largest_eigenvalue(sum) / mass)
            .collect()
    }

    /// A bound on the rates, 1/s, at which forces that grow with velocity dampen a vibration beside the
    /// scene's own damping; 0 without such forces.
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

    /// The root of the largest `mu_i + mu_j` over the edges that have any stiffness, 1/s.
    fn over_edges(&self, mu: &[f64]) -> f64 {
        let sums = self.joined().map(|&[i, j]| mu[i] + mu[j]);
        // A node without a bar swings by itself.
        mu.iter().copied().chain(sums).fold(0.0, f64::max).sqrt()
    }

    /// The edges that join their nodes: those with any stiffness.
    fn joined(&self) -> impl Iterator<Item = &'a [usize; 2]> {
        let edges = self.lattice.edges.iter().zip(&self.body.stiffness);
        edges.filter(|(_, k)| **k != 0.0).map(|(nodes, _)| nodes)
    }
}

fn largest_eigenvalue(of: &Matrix2<f64>) -> f64 {
    0.5 * of.trace() + (0.5 * (of.m11 - of.m22)).hypot(of.m12)
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::Vibration;
    use crate::design::{Design, Material};
    use crate::lattice::{Body, Lattice};
    use crate::scene::{MaterialSettings, PhysicsSettings};

    /// The largest frequency, 1/s, from all eigenvalues of the dense matrix.
    fn of_dense_matrix(vibration: &Vibration) -> f64 {
        let root: Vec<f64> = vibration
            .body
            .mass
            .iter()
            .map(|m| m.sqrt().recip())
            .collect();
        let size = 2 * root.len();
        let unit =
            |column: usize| DVector::from_fn(size, |row, _| f64::from(u8::from(row == column)));
        let columns: Vec<_> = (0..size)
            .map(|k| vibration.product(&unit(k), &root))
            .collect();
        let matrix = DMatrix::from_columns(&columns);
        matrix.symmetric_eigenvalues().max().max(0.0).sqrt()
    }

    /// Layouts of a lattice of 4 x 3 nodes, some of which have two nearly equal frequencies.
    #[test]
    fn the_largest_frequency_is_found_among_close_ones() {
        let physics = PhysicsSettings::default();
        let lattice = Lattice::sample(4, 3, 0.0);
        let mut worst: f64 = 0.0;
        for layout in 0..2000_usize {
            let material = |e: usize| Material::ALL[(layout * (e * e + 7 * e + 3) / 5 + e) % 3];
            let design = Design::Layout((0..lattice.edges.len()).map(material).collect());
            let body = Body::new(&design, &lattice, &MaterialSettings::default(), &physics);
            let vibration = Vibration::new(&lattice, &body, &physics, &lattice.positions);
            let expected = of_dense_matrix(&vibration);
            let off = vibration.largest_frequency() / expected - 1.0;
            worst = if off.abs() > worst.abs() { off } else { worst };
        }
        assert!(worst.abs() < 1e-9, "off by {worst:e} of itself");
    }

    /// Two springs that share no node, one stiffer than the other by a few parts in 1e8.
    #[test]
    fn the_largest_of_two_nearly_equal_frequencies_is_found() {
        let positions = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 5.0], [0.0, 6.0]];
        let lattice = Lattice::between(positions, vec![[0, 1], [2, 3]]);
        for excess in [1e-6, 1e-7, 3e-8, 1e-8, 1e-9, 0.0] {
            let body = Body {
                stiffness: vec![50.0, 50.0 * (1.0 + excess)],
                strain: vec![0.0; 2],
                mass: vec![0.01; 4],
                presence: Vec::new(),
            };
            let physics = PhysicsSettings::default();
            let vibration = Vibration::new(&lattice, &body, &physics, &lattice.positions);
            let off = vibration.largest_frequency() / (1e4 * (1.0 + excess)).sqrt() - 1.0;
            // The softening of a length of 1 m is 5e-13 of it.
            assert!(
                off.abs() < 1e-11,
                "off by {off:e} with an excess of {excess:e}"
            );
        }
    }
}
