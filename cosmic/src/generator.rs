//! Generates lattices. The nodes are on a grid of squares or triangles, with edges between neighbours, or they come
//! from a truss. All other modules use only nodes and edges, not columns and rows.

use crate::geometry::{Ground, Vector};
use crate::lattice::{Lattice, Payload};
use crate::scene::{LatticeKind, LatticeSettings};

impl Lattice {
    /// Generates the lattice that `settings` describe. It stands on `ground` and is rotated with it (D1). The rest
    /// length of each edge is the initial distance of its two nodes.
    ///
    /// # Panics
    /// If the settings name a truss file that was not read yet. Reading a scene also reads its truss file.
    pub fn new(settings: &LatticeSettings, ground: impl Into<Ground>) -> Self {
        let ground = ground.into();
        if let Some(truss) = settings.file.truss() {
            let positions = truss.nodes.iter().map(|&x| ground.point_to_world(x));
            let lattice = Self::of_truss(truss, positions.collect());
            let scale = settings.scale(lattice.spacing);
            return Self { scale, ..lattice };
        }
        // The positions follow D1 without rounding errors: with `drop = 0` the lowest row is exactly on the ground.
        let places = places(settings);
        let origin = Vector::new([settings.origin_x, settings.drop]);
        let position =
            |&place: &Vector<f64>| ground.point_to_world(origin + place * settings.spacing);
        let positions: Vec<Vector<f64>> = places.iter().map(position).collect();
        let edges = edges_of(settings.kind, settings.columns, settings.rows);
        Self {
            places,
            spacing: settings.spacing,
            scale: settings.scale(settings.spacing),
            payload: Payload::at(settings.payload),
            ..Self::between(positions, edges)
        }
    }
}

/// The height of an equilateral triangle with sides of length 1.
const TRIANGLE: f64 = 0.866_025_403_784_438_6;

/// The places of the nodes in units of the spacing. Nodes are ordered row by row from the lowest row, each row from
/// left to right. On a triangular lattice every second row is shifted by half a spacing.
pub(crate) fn places(settings: &LatticeSettings) -> Vec<Vector<f64>> {
    let LatticeSettings { columns, rows, .. } = *settings;
    let place = |node: usize| {
        let (row, column) = (node / columns, (node % columns) as f64);
        Vector::new(match settings.kind {
            LatticeKind::Rectangular => [column, row as f64],
            LatticeKind::Triangular => [column + 0.5 * (row % 2) as f64, row as f64 * TRIANGLE],
        })
    };
    (0..columns * rows).map(place).collect()
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
            LatticeKind::Rectangular => [
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

#[cfg(test)]
mod tests {
    use super::{Ground, Lattice, LatticeKind, LatticeSettings, Vector, edges};

    impl Lattice {
        /// A lattice with the spacing and the ground height of the default scene.
        pub(crate) fn sample(columns: usize, rows: usize, incline_deg: f64) -> Self {
            let settings = LatticeSettings {
                columns,
                rows,
                ..LatticeSettings::default()
            };
            let ground = Ground {
                height: 0.1,
                incline_deg,
            };
            Self::new(&settings, ground)
        }
    }

    #[test]
    fn edge_counts_are_those_of_the_paper() {
        for (columns, rows, count) in [(6, 6, 110), (5, 5, 72), (2, 2, 6), (4, 1, 3), (1, 3, 2)] {
            assert_eq!(edges(columns, rows).len(), count);
        }
    }

    #[test]
    fn the_lattice_is_rotated_with_the_ground() {
        let flat = Lattice::sample(4, 3, 0.0);
        let turned = Lattice::sample(4, 3, -20.0);
        for (a, b) in flat.rest_length.iter().zip(&turned.rest_length) {
            // Coordinates below 1 have rounding errors of 1e-16.
            assert!((a - b).abs() < 1e-15);
        }
        let (sin, cos) = (-20f64).to_radians().sin_cos();
        let first = Vector::new([0.1 * cos, 0.1 + 0.1 * sin]);
        assert!(turned.positions[0].distance(first) < 1e-15);
    }

    #[test]
    fn midpoints_run_from_the_lowest_row_to_the_topmost() {
        let lattice = Lattice::sample(3, 4, 0.0);
        let heights: Vec<f64> = lattice.midpoints().map(Vector::up).collect();
        assert_eq!(heights.first(), Some(&0.0));
        assert_eq!(heights.last(), Some(&3.0));
        assert_eq!(lattice.extent(), [2.0, 3.0]);
    }

    fn triangular(columns: usize, rows: usize) -> Lattice {
        let settings = LatticeSettings {
            kind: LatticeKind::Triangular,
            columns,
            rows,
            ..LatticeSettings::default()
        };
        Lattice::new(
            &settings,
            Ground {
                height: 0.1,
                incline_deg: 0.0,
            },
        )
    }

    #[test]
    fn triangles_are_equilateral_and_leave_no_gap() {
        for (columns, rows) in [(6, 6), (2, 2), (3, 5), (7, 4)] {
            let lattice = triangular(columns, rows);
            let count = rows * (columns - 1) + (rows - 1) * (2 * columns - 1);
            assert_eq!(lattice.edges.len(), count);
            // Coordinates below 1 have rounding errors of 1e-16.
            let is_side = |length: &f64| (length - 0.1).abs() < 1e-15;
            assert!(lattice.rest_length.iter().all(is_side));
            // Euler's formula for a triangulated disc: triangles = edges + 1 - nodes.
            let triangles = count + 1 - columns * rows;
            assert_eq!(triangles, 2 * (columns - 1) * (rows - 1));
        }
    }

    /// Nodes are numbered row by row from the lowest row, each row from left to right. The edges of a node go to its
    /// right, upper-right and upper-left neighbour, in this order.
    #[test]
    fn triangles_are_numbered_row_by_row() {
        let lattice = triangular(3, 3);
        assert_eq!(
            lattice.edges[..9],
            [
                [0, 1],
                [0, 3],
                [1, 2],
                [1, 4],
                [1, 3],
                [2, 5],
                [2, 4],
                [3, 4],
                [3, 7]
            ]
        );
        let heights = [0, 3, 6].map(|node| lattice.places[node].up());
        assert_eq!(heights, [0.0, 0.75f64.sqrt(), 2.0 * 0.75f64.sqrt()]);
        assert_eq!(
            [0, 3, 6].map(|node| lattice.places[node].forward()),
            [0.0, 0.5, 0.0]
        );
    }
}
