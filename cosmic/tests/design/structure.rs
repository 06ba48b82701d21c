use crate::small::lattice;
use cosmic::design::Material::{Actuator, Skeleton, Void};
use cosmic::design::{LayoutRules, MOST_RANKED, Material, Structure};
use cosmic::geometry::{Dimension, Vector};
use cosmic::lattice::Lattice;
use cosmic::scene::DesignSettings;

/// The layout in which only these edges are bars.
fn layout(lattice: &Lattice, bars: &[[usize; 2]]) -> Vec<Material> {
    let is_bar = |ends: &[usize; 2]| bars.contains(ends) || bars.contains(&[ends[1], ends[0]]);
    let material = |ends: &[usize; 2]| if is_bar(ends) { Skeleton } else { Void };
    let layout: Vec<_> = lattice.edges.iter().map(material).collect();
    let solid = layout.iter().filter(|m| m.is_solid()).count();
    assert_eq!(solid, bars.len(), "the lattice has no such edge");
    layout
}

#[test]
fn structures_are_counted() {
    let lattice = lattice(3, 2, 0.0);
    let node = |x: f64, y: f64| {
        let at = |place: &Vector<f64>| place.distance(Vector::from([x, y])) < 1e-9;
        lattice.places.iter().position(at).unwrap()
    };
    let [a, b, c] = [0.0, 1.0, 2.0].map(|x| node(x, 0.0));
    let [d, e, f] = [0.0, 1.0, 2.0].map(|x| node(x, 1.0));
    let of = |bars: &[[usize; 2]]| Structure::new(&lattice, &layout(&lattice, bars));
    let square = [[a, b], [b, e], [e, d], [d, a]];
    let shortest = lattice.rest_length.iter().copied().reduce(f64::min);
    assert_eq!(
        of(&square),
        Structure {
            pieces: 1,
            nodes: 4,
            feet: 2,
            // A hinged square can shear.
            floppy_modes: Some(1),
            shortest_skeleton: shortest,
            ..Structure::default()
        }
    );
    let braced = [&square[..], &[[a, e], [b, d], [c, f]]].concat();
    assert_eq!(
        of(&braced),
        Structure {
            pieces: 2,
            nodes: 6,
            free_ends: 2,
            crossings: 1,
            feet: 3,
            // The loose bar can turn and move in two directions.
            floppy_modes: Some(3),
            shortest_skeleton: shortest,
            shortest_actuator: None,
        }
    );
    let mut brace = layout(&lattice, &braced);
    for (material, length) in brace.iter_mut().zip(&lattice.rest_length) {
        if material.is_solid() && Some(*length) > shortest.map(|shortest| 1.1 * shortest) {
            *material = Actuator;
        }
    }
    // The diagonals of the squares are actuators now.
    let found = Structure::new(&lattice, &brace).shortest_actuator.unwrap();
    assert!((found / shortest.unwrap() - 2.0_f64.sqrt()).abs() < 1e-9);
    let none = Structure {
        floppy_modes: Some(0),
        ..Structure::default()
    };
    assert_eq!(of(&[]), none);
}

#[test]
fn floppy_modes_are_not_counted_for_many_bars() {
    // All edges of a square lattice: it is rigid, and the braces of each cell cross.
    let of = |nodes: usize| {
        let lattice = lattice(nodes, nodes, 0.0);
        let structure = Structure::new(&lattice, &vec![Skeleton; lattice.edges.len()]);
        assert_eq!(structure.crossings, (nodes - 1).pow(2));
        (lattice.edges.len(), structure.floppy_modes)
    };
    let (bars, modes) = of(8);
    assert!(bars <= MOST_RANKED);
    assert_eq!(modes, Some(0));
    let (bars, modes) = of(64);
    assert!(bars > MOST_RANKED);
    assert_eq!(modes, None);
}

#[test]
fn loose_bars_are_faults_that_can_be_cut_or_bridged() {
    let lattice = lattice(3, 3, 0.0);
    let asked = DesignSettings {
        one_piece: true,
        ..DesignSettings::default()
    };
    let rules = LayoutRules::new(&lattice, &asked);
    let payload = lattice.payload[0].node;
    let mut layout = vec![Void; lattice.edges.len()];
    let touches = |node: usize| move |ends: &[usize; 2]| ends.contains(&node);
    let own = lattice.edges.iter().position(touches(payload)).unwrap();
    let apart = |ends: &[usize; 2]| {
        !ends.contains(&payload) && { lattice.edges[own].iter().all(|node| !ends.contains(node)) }
    };
    let loose = lattice.edges.iter().rposition(apart).unwrap();
    layout[own] = Skeleton;
    assert_eq!(rules.faults(&layout), 0);
    layout[loose] = Actuator;
    assert_eq!(rules.faults(&layout), 1);
    let bridge = rules.bridge(&layout);
    assert!(!bridge.is_empty());
    // A bridge is built only for loose bars, not for other faults.
    let in_pieces = DesignSettings {
        one_piece: false,
        free_ends: false,
        ..asked.clone()
    };
    let in_pieces = LayoutRules::new(&lattice, &in_pieces);
    assert!(in_pieces.faults(&layout) > 0 && in_pieces.bridge(&layout).is_empty());
    let mut joined = layout.clone();
    bridge.iter().for_each(|&edge| joined[edge] = Skeleton);
    assert_eq!(rules.faults(&joined), 0);
    let cut = rules.without_loose_bars(&layout);
    assert_eq!((cut[own], cut[loose]), (Skeleton, Void));
    // Each requirement counts its own faults.
    let free = |asked: DesignSettings| LayoutRules::new(&lattice, &asked).faults(&cut);
    assert_eq!(free(asked.clone()), 0);
    let no_ends = DesignSettings {
        free_ends: false,
        ..asked.clone()
    };
    assert_eq!(free(no_ends), 1);
    let feet = DesignSettings { feet: 3, ..asked };
    assert_eq!(free(feet), 3 - Structure::new(&lattice, &cut).feet);
}

/// In space, nodes in one line can turn about it, which is no motion of theirs.
#[test]
fn floppy_modes_in_space_are_counted_without_the_rigid_motions() {
    let floppy = |nodes: &[[f64; 3]], edges: &[[usize; 2]]| {
        let nodes = nodes.iter().copied().map(Vector::new).collect();
        let lattice = Lattice {
            dimension: Dimension::Space,
            ..Lattice::between(nodes, edges.to_vec())
        };
        let all = vec![Skeleton; edges.len()];
        Structure::new(&lattice, &all).floppy_modes
    };
    let [a, b, c, d] = [
        [0.0, 0.0, 0.0],
        [0.1, 0.0, 0.1],
        [0.2, 0.0, 0.2],
        [0.0, 0.1, 0.0],
    ];
    assert_eq!(floppy(&[a, b], &[[0, 1]]), Some(0));
    // The node in the middle moves in the two directions across.
    assert_eq!(floppy(&[a, b, c], &[[0, 1], [1, 2]]), Some(2));
    assert_eq!(floppy(&[a, b, c], &[[0, 1], [1, 2], [0, 2]]), Some(2));
    assert_eq!(floppy(&[a, b, d], &[[0, 1], [1, 2], [0, 2]]), Some(0));
    // Two triangles turn about their common edge.
    let e = [0.1, 0.2, 0.1];
    let triangles = [[0, 1], [1, 2], [0, 2], [1, 3], [2, 3]];
    assert_eq!(floppy(&[a, b, d, e], &triangles), Some(1));
}
