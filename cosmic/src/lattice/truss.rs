//! Nodes, and the edges between them.

use super::State;
use super::own::{EdgeRules, Payload, Truss};

/// Nodes and edges of a robot. Node 0 is the first to carry payload.
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
    /// The nodes as they are laid out: along and above the ground from the lower left corner, in
    /// units of `spacing`. On a rectangular lattice these are whole numbers, column and row.
    pub places: Vec<[f64; 2]>,
    /// The distance of neighbouring nodes, in metres; the median edge's length where edges differ.
    pub spacing: f64,
    /// Nodes with extra mass, node 0 first.
    pub payload: Vec<Payload>,
    /// What the edges may be made of.
    pub rules: EdgeRules,
}

impl Lattice {
    /// Nodes at these positions (m) over level ground, and springs between them that are at rest.
    ///
    /// # Panics
    /// If an edge has a node that does not exist.
    pub fn between(positions: Vec<[f64; 2]>, edges: Vec<[usize; 2]>) -> Self {
        let truss = Truss {
            nodes: positions.clone(),
            edges,
            ..Truss::default()
        };
        Self::of_truss(&truss, positions)
    }

    /// A truss whose nodes have these positions in the world's frame.
    pub(crate) fn of_truss(truss: &Truss, positions: Vec<[f64; 2]>) -> Self {
        let distance = |&[i, j]: &[usize; 2]| {
            let (a, b) = (positions[i], positions[j]);
            (b[0] - a[0]).hypot(b[1] - a[1])
        };
        let rest_length: Vec<f64> = truss.edges.iter().map(distance).collect();
        let mut lengths = rest_length.clone();
        lengths.sort_by(f64::total_cmp);
        let median = lengths.get(lengths.len() / 2).copied();
        let spacing = median.filter(|length| *length > 0.0).unwrap_or(1.0);
        let least = |k: usize| {
            truss
                .nodes
                .iter()
                .map(|x| x[k])
                .fold(f64::INFINITY, f64::min)
        };
        let corner = [least(0), least(1)];
        let place = |x: &[f64; 2]| [0, 1].map(|k| (x[k] - corner[k]) / spacing);
        Self {
            places: truss.nodes.iter().map(place).collect(),
            positions,
            edges: truss.edges.clone(),
            rest_length,
            spacing,
            payload: truss.payload.clone(),
            rules: truss.rules.clone(),
        }
    }

    /// The nodes and edges, with the places of the nodes for their positions.
    pub(crate) fn truss(&self) -> Truss {
        Truss {
            nodes: self.places.clone(),
            edges: self.edges.clone(),
            payload: self.payload.clone(),
            rules: self.rules.clone(),
            ..Truss::default()
        }
    }

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

    /// How far the nodes reach along and above the ground, in units of `spacing`.
    pub fn extent(&self) -> [f64; 2] {
        [0, 1].map(|k| self.places.iter().map(|place| place[k]).fold(0.0, f64::max))
    }

    /// The width with half a spacing around, in metres.
    pub fn width(&self) -> f64 {
        let [width, _] = self.extent();
        (width + 1.0) * self.spacing
    }

    /// The larger of width and height with half a spacing around, in metres.
    pub fn side(&self) -> f64 {
        let [width, height] = self.extent();
        (width.max(height) + 1.0) * self.spacing
    }

    /// The places of the edges' midpoints, in units of `spacing`.
    pub fn midpoints(&self) -> impl Iterator<Item = [f64; 2]> {
        self.edges.iter().map(|&[i, j]| {
            let (a, b) = (self.places[i], self.places[j]);
            [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]
        })
    }

    /// The places from one end of an edge to the other, in units of `spacing`.
    pub fn direction(&self, [i, j]: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.places[j][k] - self.places[i][k])
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

/// How fast an edge grows, m/s.
pub fn rate(state: &State<f64>, ends: [usize; 2]) -> f64 {
    let [d, dv] = [&state.x, &state.v].map(|of| [0, 1].map(|k| of[ends[1]][k] - of[ends[0]][k]));
    (d[0] * dv[0] + d[1] * dv[1]) / length(&state.x, ends)
}
