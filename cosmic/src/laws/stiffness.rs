//! The stiffness and damping of a robot: the derivatives of its forces at a pose.

use std::ops::AddAssign;

use super::pose::Pose;
use crate::geometry::Matrix;

/// The derivatives of forces with respect to the positions (N/m) and velocities (N s/m) of the nodes.
#[derive(Clone, Debug)]
pub struct Stiffness {
    pub(crate) bars: Vec<BarStiffness>,
    /// For every edge, the derivative of its tension with respect to the rate of its length, N s/m.
    pub(crate) bar_damping: Vec<f64>,
    /// For every node, minus the derivative of the force on the node with respect to the node's own position, N/m, or a
    /// bound on what all nodes together add.
    pub(crate) nodes: Vec<Matrix>,
    /// For every node, a bound on the derivative of the force on the node with respect to the node's own velocity, N
    /// s/m.
    pub(crate) node_damping: Vec<f64>,
}

/// The stiffness of an edge for displacements along it and across it, N/m. The stiffness across the edge is the tension
/// divided by the length, and may be negative.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BarStiffness {
    pub(crate) along: f64,
    pub(crate) across: f64,
}

impl Stiffness {
    /// A bound on what the forces on single nodes add to the square of any frequency, 1/s^2. `least_mass` is the
    /// smallest mass that a node may have (kg).
    pub(crate) fn of_nodes(&self, least_mass: f64) -> f64 {
        let largest = self.nodes.iter().map(Matrix::largest_eigenvalue);
        largest.fold(0.0, f64::max) / least_mass
    }
}

impl Stiffness {
    /// The stiffness of a robot without forces.
    pub fn none(pose: &Pose) -> Self {
        let (nodes, edges) = (pose.lattice.nodes(), pose.lattice.edges.len());
        Self {
            bars: vec![BarStiffness::default(); edges],
            bar_damping: vec![0.0; edges],
            nodes: vec![Matrix::zero(); nodes],
            node_damping: vec![0.0; nodes],
        }
    }

    /// Adds the stiffness `by_place` of the force on a node, N/m: minus the derivative of that force with respect to
    /// the node's position.
    pub fn node(&mut self, node: usize, by_place: Matrix) {
        self.nodes[node] += by_place;
    }

    /// Adds the damping of a node, N s/m: a bound on the derivative of the force on the node with respect to its
    /// velocity.
    pub fn dampen_node(&mut self, node: usize, damping: f64) {
        self.node_damping[node] += damping;
    }
}

impl AddAssign for Stiffness {
    fn add_assign(&mut self, other: Self) {
        for (bar, added) in self.bars.iter_mut().zip(other.bars) {
            bar.along += added.along;
            bar.across += added.across;
        }
        let damping = self.bar_damping.iter_mut().chain(&mut self.node_damping);
        let added = other.bar_damping.iter().chain(&other.node_damping);
        damping.zip(added).for_each(|(sum, added)| *sum += added);
        let nodes = self.nodes.iter_mut().zip(other.nodes);
        nodes.for_each(|(sum, added)| *sum += added);
    }
}
