//! The stiffness and damping of a robot: the derivatives of its forces at a pose.

use crate::geometry::Matrix;

/// The derivatives of the forces with respect to the positions (N/m) and velocities (N s/m) of the nodes. Each force
/// adds its part in [`Force::stiffen`].
///
/// [`Force::stiffen`]: super::Force::stiffen
#[derive(Clone, Debug)]
pub struct Stiffness {
    pub(crate) bars: Vec<BarStiffness>,
    /// For every edge, the derivative of its tension with respect to the rate of its length, N s/m.
    pub(crate) bar_damping: Vec<f64>,
    /// For every node, minus the derivative of the force on the node with respect to the node's own position, N/m.
    pub(crate) nodes: Vec<Matrix>,
    /// For every node, a bound on the derivative of the force on the node with respect to the node's own velocity, N
    /// s/m.
    pub(crate) node_damping: Vec<f64>,
}

/// The stiffness of an edge for displacements along it and across it, N/m. The stiffness across the edge may be
/// negative.
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
    pub(crate) fn none(nodes: usize, edges: usize) -> Self {
        Self {
            bars: vec![BarStiffness::default(); edges],
            bar_damping: vec![0.0; edges],
            nodes: vec![Matrix::zero(); nodes],
            node_damping: vec![0.0; nodes],
        }
    }

    /// Adds to the stiffness of an edge, N/m: `along` for displacements along the edge, and `across` for displacements
    /// across it. The latter is the tension divided by the length.
    pub fn bar(&mut self, edge: usize, along: f64, across: f64) {
        let bar = &mut self.bars[edge];
        (bar.along, bar.across) = (bar.along + along, bar.across + across);
    }

    /// Adds `damping` to the derivative of an edge's tension with respect to the rate of its length, N s/m.
    pub fn dampen_bar(&mut self, edge: usize, damping: f64) {
        self.bar_damping[edge] += damping;
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
