//! The slopes of the forces at a pose: a robot's stiffness and what dampens it.

/// The slopes of forces by the places (N/m) and velocities (N s/m) of the nodes. [`Force::stiffen`]
/// adds to it.
///
/// [`Force::stiffen`]: super::Force::stiffen
#[derive(Clone, Debug)]
pub struct Stiffness {
    /// Of every edge along itself and across, N/m. The second may be of either sign.
    pub(crate) bars: Vec<[f64; 2]>,
    /// Of every edge by the rate of its length, N s/m.
    pub(crate) bar_damping: Vec<f64>,
    /// Of every node by its own place, a symmetric matrix, N/m.
    pub(crate) nodes: Vec<[[f64; 2]; 2]>,
    /// Of every node by its own velocity, N s/m.
    pub(crate) node_damping: Vec<f64>,
    /// Angles between edges that resist bending.
    pub(crate) angles: Vec<Angle>,
}

/// An angle over three nodes, `g . u` by their displacements `u`, with a stiffness `c`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Angle {
    pub(crate) nodes: [usize; 3],
    /// `g` of each node, times the root of `c`.
    pub(crate) by: [[f64; 2]; 3],
}

impl Stiffness {
    pub(crate) fn none(nodes: usize, edges: usize) -> Self {
        Self {
            bars: vec![[0.0; 2]; edges],
            bar_damping: vec![0.0; edges],
            nodes: vec![[[0.0; 2]; 2]; nodes],
            node_damping: vec![0.0; nodes],
            angles: Vec::new(),
        }
    }

    /// What forces on single nodes add to the square of any frequency at most, 1/s^2, where no node is
    /// lighter than this (kg).
    pub(crate) fn of_nodes(&self, least_mass: f64) -> f64 {
        let largest = |[[a, b], [_, d]]: &[[f64; 2]; 2]| 0.5 * (a + d) + (0.5 * (a - d)).hypot(*b);
        self.nodes.iter().map(largest).fold(0.0, f64::max) / least_mass
    }

    /// Adds the stiffness of an edge along itself, and across: its tension over its length, N/m.
    pub fn bar(&mut self, edge: usize, along: f64, across: f64) {
        let [a, b] = &mut self.bars[edge];
        (*a, *b) = (*a + along, *b + across);
    }

    /// Adds to the slope of an edge's tension by the rate of its length, N s/m.
    pub fn dampen_bar(&mut self, edge: usize, damping: f64) {
        self.bar_damping[edge] += damping;
    }

    /// Adds to minus the derivative of the force on a node by its place, N/m; the symmetric part counts.
    pub fn node(&mut self, node: usize, by_place: [[f64; 2]; 2]) {
        let [[a, b], [c, d]] = by_place;
        let off = 0.5 * (b + c);
        for (sums, added) in self.nodes[node].iter_mut().zip([[a, off], [off, d]]) {
            (sums[0], sums[1]) = (sums[0] + added[0], sums[1] + added[1]);
        }
    }

    /// Adds to minus the slope of the force on a node by its velocity, N s/m, in the direction in which it
    /// is largest.
    pub fn dampen_node(&mut self, node: usize, damping: f64) {
        self.node_damping[node] += damping;
    }

    /// Adds an angle over three nodes, the derivatives `g` of which by their places (1/m) are given with
    /// its stiffness (N m).
    pub fn angle(&mut self, nodes: [usize; 3], g: [[f64; 2]; 3], stiffness: f64) {
        let by = g.map(|g| g.map(|x| x * stiffness.sqrt()));
        self.angles.push(Angle { nodes, by });
    }
}
