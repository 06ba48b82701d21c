use crate::small::lattice;
use cosmic::laws::{Bend, BentBars, Line, Pair, pairs};

#[test]
fn every_line_of_three_nodes_is_a_pair() {
    // Three nodes in line occur four times in each row and column, and 4 x 4 times in each of the two diagonal
    // directions.
    assert_eq!(pairs(&lattice(6, 6, 0.0)).len(), 6 * 4 + 6 * 4 + 2 * 4 * 4);
    assert_eq!(pairs(&lattice(6, 6, 15.0)), pairs(&lattice(6, 6, 0.0)));
    assert_eq!(pairs(&lattice(2, 2, 0.0)), []);
    let line = Pair {
        nodes: [0, 1, 2],
        edges: [0, 3],
    };
    assert_eq!(pairs(&lattice(3, 2, 0.0))[0], line);
}

#[test]
fn nothing_is_recorded_if_bars_bend_freely() {
    assert!(BentBars::new(&lattice(6, 6, 0.0), 0.0).is_none());
    assert!(BentBars::new(&lattice(2, 2, 0.0), 0.01).is_none());
    let bending = BentBars::new(&lattice(6, 6, 0.0), 0.01).unwrap();
    let shapes = bending.pairs.chunk_by(|a, b| a.shape() == b.shape());
    assert_eq!((shapes.count(), bending.pairs.len()), (4, 80));
}

#[test]
fn equal_edges_bend_as_one_bar_and_void_ones_freely() {
    let bend = Bend {
        section: 2.0 * 0.01 * 0.01,
        dt: 1.0,
    };
    // The expected angular stiffness is k r^2; `LEAST_STIFFNESS` reduces it by a fraction of 1e-15.
    let stiffness = |first: f64, second: f64| {
        bend.stiffness(&Line::new([0.0, 0.0, 0.1, 0.0, 0.2, 0.0, first, second]))
    };
    assert!((stiffness(400.0, 400.0) - 0.04).abs() < 1e-15);
    assert_eq!([stiffness(400.0, 0.0), stiffness(0.0, 0.0)], [0.0; 2]);
}
