//! The generator of lattices: nodes on a square grid, and the edges between neighbours.

use crate::ground::Ground;
use crate::lattice::Lattice;
use crate::scene::LatticeSettings;

impl Lattice {
    /// The lattice on a ground, turned with it (D1); each rest length is the plain initial distance
    /// of the two nodes.
    pub fn new(settings: &LatticeSettings, ground: impl Into<Ground>) -> Self {
        let LatticeSettings { columns, rows, .. } = *settings;
        let ground = ground.into();
        // The numbers of D1 themselves: with `drop = 0` the lowest row is exactly on the ground.
        let place = |node: usize| {
            let (row, column) = (node / columns, node % columns);
            ground.point_to_world([
                settings.origin_x + column as f64 * settings.spacing,
                settings.drop + row as f64 * settings.spacing,
            ])
        };
        let positions: Vec<[f64; 2]> = (0..columns * rows).map(place).collect();
        let edges = edges(columns, rows);
        let rest_length = edges
            .iter()
            .map(|&[i, j]| distance(positions[i], positions[j]))
            .collect();
        Self {
            positions,
            edges,
            rest_length,
            columns,
            rows,
        }
    }
}

/// Every horizontal, vertical and diagonal of every cell as `[i, j]`, `i < j`: nodes ascending;
/// for each, the edges to its right, upper, upper-right and upper-left neighbour where they exist.
pub fn edges(columns: usize, rows: usize) -> Vec<[usize; 2]> {
    let mut edges = Vec::new();
    for node in 0..columns * rows {
        let (row, column) = (node / columns, node % columns);
        let right = column + 1 < columns;
        let up = row + 1 < rows;
        let above = node + columns;
        let neighbours = [
            (right, node + 1),
            (up, above),
            (up && right, above + 1),
            (up && column > 0, above.wrapping_sub(1)),
        ];
        let exist = neighbours.iter().filter(|(exists, _)| *exists);
        edges.extend(exist.map(|&(_, neighbour)| [node, neighbour]));
    }
    edges
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}

#[cfg(test)]
mod tests {
    use super::{Ground, Lattice, LatticeSettings, edges};

    impl Lattice {
        /// A lattice of the default scene's spacing on a ground of its height.
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
    fn the_lattice_turns_with_the_ground() {
        let flat = Lattice::sample(4, 3, 0.0);
        let turned = Lattice::sample(4, 3, -20.0);
        for (a, b) in flat.rest_length.iter().zip(&turned.rest_length) {
            // Coordinates below 1 carry roundings of 1e-16.
            assert!((a - b).abs() < 1e-15);
        }
        let [x, y] = turned.positions[0];
        let (sin, cos) = (-20f64).to_radians().sin_cos();
        assert!((x - 0.1 * cos).abs() < 1e-15 && (y - (0.1 + 0.1 * sin)).abs() < 1e-15);
    }

    #[test]
    fn midpoints_run_from_the_lowest_row_to_the_topmost() {
        let rows = Lattice::sample(3, 4, 0.0).midpoint_rows();
        assert_eq!(rows.first(), Some(&0.0));
        assert_eq!(rows.last(), Some(&3.0));
    }
}
