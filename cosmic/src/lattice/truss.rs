//! Nodes, and the edges between them.

use super::State;

/// Nodes and edges of a robot. Node 0 is at the bottom left and carries the payload.
///
/// All of it is constant: no derivative flows through the rest lengths or the masses that come
/// from them, not even where the initial positions are variables.
#[derive(Clone, Debug, PartialEq)]
pub struct Lattice {
    /// Initial positions in the world's frame, one per node, in metres.
    pub positions: Vec<[f64; 2]>,
    /// Nodes `[i, j]` that an edge joins.
    pub edges: Vec<[usize; 2]>,
    /// Rest length per edge, in metres.
    pub rest_length: Vec<f64>,
    /// Nodes in a row.
    pub columns: usize,
    /// How many rows.
    pub rows: usize,
}

impl Lattice {
    /// How many nodes.
    pub fn nodes(&self) -> usize {
        self.positions.len()
    }

    /// The state in which the robot starts: its initial positions, everything at rest.
    pub fn state_at_rest(&self) -> State<f64> {
        State {
            x: self.positions.clone(),
            v: vec![[0.0; 2]; self.nodes()],
        }
    }

    /// Heights of the edges' midpoints above the lowest row, in rows: 0 for an
    /// edge along the lowest row, `rows - 1` for one along the topmost.
    pub fn midpoint_rows(&self) -> Vec<f64> {
        let row = |node: usize| (node / self.columns) as f64;
        self.edges
            .iter()
            .map(|&[i, j]| 0.5 * (row(i) + row(j)))
            .collect()
    }
}

/// Added to the square of an edge's length, m^2, so that the length is smooth where its nodes
/// coincide (D4).
pub const SOFTENING: f64 = 1e-12;

/// The length of an edge, m, as forces have it (D4).
pub fn length(x: &[[f64; 2]], [i, j]: [usize; 2]) -> f64 {
    let [dx, dy] = [0, 1].map(|k| x[j][k] - x[i][k]);
    (dx * dx + dy * dy + SOFTENING).sqrt()
}
