//! A robot's stiffness and damping: the derivatives of its forces at a pose.

use crate::geometry::{Matrix, Vector};

/// The derivatives of the forces with respect to the positions (N/m) and velocities (N s/m) of the nodes. Each force
/// adds its part in [`Force::stiffen`].
///
/// [`Force::stiffen`]: super::Force::stiffen
#[derive(Clone, Debug)]
pub struct Stiffness<const D: usize = 2> {
    pub(crate) bars: Vec<BarStiffness>,
    /// For every edge, the derivative of its tension with respect to the rate of its length, N s/m.
    pub(crate) bar_damping: Vec<f64>,
    /// For every node, minus the derivative of the force on it with respect to its own position, N/m.
    pub(crate) nodes: Vec<Matrix<D>>,
    /// For every node, a bound on the derivative of the force on it with respect to its own velocity, N s/m.
    pub(crate) node_damping: Vec<f64>,
    /// Angles between edges that resist bending.
    pub(crate) angles: Vec<Angle<D>>,
}

/// The stiffness of an edge along its direction and across it, N/m. The stiffness across may be negative.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BarStiffness {
    pub(crate) along: f64,
    pub(crate) across: f64,
}

/// An angle over three nodes with an angular stiffness `c`. The angle is `g . u` if the nodes are displaced by `u`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Angle<const D: usize = 2> {
    pub(crate) nodes: [usize; 3],
    /// The vector `g` of each node, times the square root of `c`.
    pub(crate) by: [Vector<f64, D>; 3],
}

impl Stiffness {
    /// A bound on what forces on single nodes add to the square of any frequency, 1/s^2, if every node has at least
    /// this mass (kg).
    pub(crate) fn of_nodes(&self, least_mass: f64) -> f64 {
        let largest = self.nodes.iter().map(Matrix::largest_eigenvalue);
        largest.fold(0.0, f64::max) / least_mass
    }
}

impl<const D: usize> Stiffness<D> {
    pub(crate) fn none(nodes: usize, edges: usize) -> Self {
        Self {
            bars: vec![BarStiffness::default(); edges],
            bar_damping: vec![0.0; edges],
            nodes: vec![Matrix::zero(); nodes],
            node_damping: vec![0.0; nodes],
            angles: Vec::new(),
        }
    }

    /// Adds to the stiffness of an edge, N/m: `along` its direction, and `across` it, which is the tension divided by
    /// the length.
    pub fn bar(&mut self, edge: usize, along: f64, across: f64) {
        let bar = &mut self.bars[edge];
        (bar.along, bar.across) = (bar.along + along, bar.across + across);
    }

    /// Adds to the derivative of an edge's tension with respect to the rate of its length, N s/m.
    pub fn dampen_bar(&mut self, edge: usize, damping: f64) {
        self.bar_damping[edge] += damping;
    }

    /// Adds minus the derivative of the force on a node with respect to its position, N/m.
    pub fn node(&mut self, node: usize, by_place: Matrix<D>) {
        self.nodes[node] += by_place;
    }

    /// Adds a bound on the derivative of the force on a node with respect to its velocity, N s/m.
    pub fn dampen_node(&mut self, node: usize, damping: f64) {
        self.node_damping[node] += damping;
    }

    /// Adds an angle over three nodes: its derivatives `g` with respect to their positions (1/m), and its `stiffness`
    /// (N m).
    pub fn angle(&mut self, nodes: [usize; 3], g: [Vector<f64, D>; 3], stiffness: f64) {
        let by = g.map(|g| g * stiffness.sqrt());
        self.angles.push(Angle { nodes, by });
    }
}
