use crate::small::lattice;
use cosmic::geometry::{Ground, Vector};
use cosmic::lattice::Lattice;
use cosmic::scene::{LatticeKind, LatticeSettings};

#[test]
fn the_lattice_is_rotated_with_the_ground() {
    let flat = lattice(4, 3, 0.0);
    let turned = lattice(4, 3, -20.0);
    for (a, b) in flat.rest_length.iter().zip(&turned.rest_length) {
        // Coordinates below 1 have rounding errors of 1e-16.
        assert!((a - b).abs() < 1e-15);
    }
    let (sin, cos) = (-20f64).to_radians().sin_cos();
    let last_column = Vector::from([0.3 * cos, 0.3 * sin]);
    assert!(turned.positions[3].distance(last_column) < 1e-15);
}

fn triangular(columns: usize, rows: usize) -> Lattice {
    let settings = LatticeSettings {
        kind: LatticeKind::Triangular,
        columns,
        rows,
        ..LatticeSettings::default()
    };
    Lattice::new(&settings, Ground { incline_deg: 0.0 })
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

/// The counts of a lattice of 6x6x4 cubes: 616 edges along the axes and 1032 diagonals of faces.
#[test]
fn cubes_have_edges_along_axes_and_diagonals() {
    let settings = |body_diagonals| LatticeSettings {
        kind: LatticeKind::Cubic,
        columns: 7,
        depth: 7,
        rows: 5,
        body_diagonals,
        ..LatticeSettings::default()
    };
    let ground = Ground { incline_deg: 0.0 };
    let [plain, braced] = [false, true].map(|diagonals| Lattice::new(&settings(diagonals), ground));
    assert_eq!((plain.nodes(), plain.edges.len()), (245, 616 + 1032));
    assert_eq!(braced.edges.len(), 616 + 1032 + 4 * 6 * 6 * 4);
    let along_axes = |length: &&f64| (**length - 0.1).abs() < 1e-12;
    assert_eq!(plain.rest_length.iter().filter(along_axes).count(), 616);
    let mut sorted = braced.edges.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, braced.edges);
}
