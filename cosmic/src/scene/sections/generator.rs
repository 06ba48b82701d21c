//! Generates lattices. The nodes are on a grid of squares or triangles, with edges between neighbours, or they come
//! from a truss. All other modules use only nodes and edges, not columns and rows.

use super::robot::{LatticeKind, LatticeSettings};
use crate::geometry::{Ground, Vector};
use crate::lattice::{Lattice, Payload};

impl Lattice {
    /// Generates the lattice that `settings` describe. It stands on `ground` and is rotated with it (D1). The rest
    /// length of each edge is the initial distance of its two nodes.
    ///
    /// # Panics
    /// If the settings name a truss file that was not read yet. Reading a scene also reads its truss file.
    pub fn new(settings: &LatticeSettings, ground: impl Into<Ground>) -> Self {
        let ground = ground.into();
        if let Some(truss) = settings.file.truss() {
            let positions = truss.nodes.iter().map(|&x| ground.vector_to_world(x));
            let lattice = Self::of_truss(truss, positions.collect());
            let scale = Self::SPACINGS * lattice.spacing;
            return settings.mirrored(Self { scale, ..lattice });
        }
        // The positions have no rounding errors: with `drop = 0` the lowest row is exactly on the ground.
        let places = places(settings);
        let lowest = Vector::upright(0.0, settings.drop);
        let position =
            |&place: &Vector<f64>| ground.vector_to_world(lowest + place * settings.spacing);
        let positions: Vec<Vector<f64>> = places.iter().map(position).collect();
        let edges = match settings.is_cubic() {
            true => cubic_edges(settings),
            false => edges_of(settings.kind, settings.columns, settings.rows),
        };
        settings.mirrored(Self {
            dimension: settings.dimension(),
            places,
            spacing: settings.spacing,
            scale: Self::SPACINGS * settings.spacing,
            payload: Payload::at(settings.payload),
            ..Self::between(positions, edges)
        })
    }
}

impl LatticeSettings {
    /// The lattice as these settings want it: as it is, or as its own [mirror image](Lattice::mirrored).
    pub(crate) fn mirrored(&self, lattice: Lattice) -> Lattice {
        match self.mirror {
            true => lattice.mirrored(),
            false => lattice,
        }
    }
}

/// The height of an equilateral triangle with sides of length 1.
const TRIANGLE: f64 = 0.866_025_403_784_438_6;

/// The places of the nodes in units of the spacing. Nodes are ordered row by row from the lowest row, each row from
/// left to right. On a triangular lattice every second row is shifted by half a spacing.
pub(crate) fn places(settings: &LatticeSettings) -> Vec<Vector<f64>> {
    let LatticeSettings { columns, .. } = *settings;
    let place = |node: usize| {
        let (row, column) = (node / columns, (node % columns) as f64);
        Vector::from(match settings.kind {
            LatticeKind::Rectangular => [column, row as f64],
            LatticeKind::Triangular => [column + 0.5 * (row % 2) as f64, row as f64 * TRIANGLE],
            LatticeKind::Cubic => {
                let (row, across) = (row / settings.depth, row % settings.depth);
                return Vector::new([column, across as f64, row as f64]);
            }
        })
    };
    (0..settings.nodes()).map(place).collect()
}

/// The edges of a cubic lattice, each as `[i, j]` with `i < j`, ascending: all neighbours along the axes, both diagonals of
/// every face, and the body diagonals if the settings want them.
fn cubic_edges(settings: &LatticeSettings) -> Vec<[usize; 2]> {
    let sizes = [settings.rows, settings.depth, settings.columns];
    let number = |[row, across, column]: [usize; 3]| (row * sizes[1] + across) * sizes[2] + column;
    let most = if settings.body_diagonals { 3 } else { 2 };
    let steps = (0..27).map(|k| [k / 9, k / 3 % 3, k % 3].map(|step: i64| step - 1));
    let steps: Vec<[i64; 3]> = steps
        .filter(|step| *step > [0; 3] && step.iter().filter(|part| **part != 0).count() <= most)
        .collect();
    let neighbours = |node: usize| {
        let at = [
            node / (sizes[1] * sizes[2]),
            node / sizes[2] % sizes[1],
            node % sizes[2],
        ];
        let moved = steps
            .iter()
            .map(move |step| [0, 1, 2].map(|k| at[k] as i64 + step[k]));
        let inside = moved.filter(|at| (0..3).all(|k| (0..sizes[k] as i64).contains(&at[k])));
        inside.map(move |at| [node, number(at.map(|place| place as usize))])
    };
    (0..settings.nodes()).flat_map(neighbours).collect()
}

/// The edges of a rectangular lattice, each as `[i, j]` with `i < j`. They are ordered by node `i`. For each node come
/// the edges to its right, upper, upper-right and upper-left neighbour, if these exist.
pub fn edges(columns: usize, rows: usize) -> Vec<[usize; 2]> {
    edges_of(LatticeKind::Rectangular, columns, rows)
}

/// Like [`edges`], for a lattice of any kind. A node of a triangular lattice has no edge straight up.
fn edges_of(kind: LatticeKind, columns: usize, rows: usize) -> Vec<[usize; 2]> {
    let mut edges = Vec::new();
    for node in 0..columns * rows {
        let (row, column) = (node / columns, node % columns);
        let right = column + 1 < columns;
        let up = row + 1 < rows;
        let above = node + columns;
        // The row above is shifted by half a spacing relative to this row: to the right or to the left, in turn.
        let shifted = row % 2;
        let neighbours = match kind {
            LatticeKind::Rectangular | LatticeKind::Cubic => [
                (right, node + 1),
                (up, above),
                (up && right, above + 1),
                (up && column > 0, above.wrapping_sub(1)),
            ],
            LatticeKind::Triangular => [
                (right, node + 1),
                (false, 0),
                (up && column + shifted < columns, above + shifted),
                (
                    up && column + shifted > 0,
                    (above + shifted).wrapping_sub(1),
                ),
            ],
        };
        let exist = neighbours.iter().filter(|(exists, _)| *exists);
        edges.extend(exist.map(|&(_, neighbour)| [node, neighbour]));
    }
    edges
}
