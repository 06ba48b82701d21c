//! Lattices that are their own mirror image.

use crate::small::lattice;
use cosmic::lattice::{Lattice, Mirror, Payload};
use cosmic::scene::{LatticeKind, LatticeSettings, Scene};
use cosmic::search::CoDesign;

#[test]
fn nodes_and_edges_have_images_on_the_other_side() {
    let lattice = Lattice {
        payload: Payload::at(4),
        ..lattice(3, 2, 20.0)
    };
    let image = lattice.image().unwrap();
    assert_eq!(image.nodes, [2, 1, 0, 5, 4, 3]);
    for (edge, &other) in image.edges.iter().enumerate() {
        assert_eq!(image.edges[other], edge);
        let mut ends = lattice.edges[edge].map(|node| image.nodes[node]);
        let mut expected = lattice.edges[other];
        ends.sort_unstable();
        expected.sort_unstable();
        assert_eq!(ends, expected);
    }
    // Edges that mirror one another are tied. The two upright edges in the middle are their own images.
    let ties = lattice.clone().mirrored().rules.tie;
    let own = image
        .edges
        .iter()
        .enumerate()
        .filter(|(edge, image)| edge == *image);
    assert_eq!(2 * ties.len() + own.count(), lattice.edges.len());
    assert!(ties.iter().all(|tie| image.edges[tie[0]] == tie[1]));
}

#[test]
fn other_lattices_have_no_image() {
    let of = |kind, columns, payload| -> Option<Mirror> {
        let settings = LatticeSettings {
            kind,
            columns,
            rows: 2,
            payload,
            ..LatticeSettings::default()
        };
        Lattice::new(&settings, &Scene::paper().physics).image()
    };
    assert!(of(LatticeKind::Rectangular, 3, 1).is_some());
    assert!(of(LatticeKind::Rectangular, 3, 0).is_none());
    // An even number of columns has no node in the middle.
    assert!((0..8).all(|payload| of(LatticeKind::Rectangular, 4, payload).is_none()));
    // The second row of triangles is half a spacing further along.
    assert!((0..6).all(|payload| of(LatticeKind::Triangular, 3, payload).is_none()));
}

/// In space, left and right are images of each other.
#[test]
fn cubes_have_images_across() {
    let settings = LatticeSettings {
        kind: LatticeKind::Cubic,
        columns: 2,
        depth: 3,
        rows: 1,
        payload: 2,
        ..LatticeSettings::default()
    };
    let image = Lattice::new(&settings, &Scene::paper().physics).image();
    assert_eq!(image.unwrap().nodes, [4, 5, 2, 3, 0, 1]);
}

/// A robot stays its own mirror image in all phases of an optimisation.
#[test]
fn an_optimised_robot_is_its_own_image() {
    let scene = "
        base = 'errand'
        [lattice]
        columns = 3
        rows = 3
        [physics]
        steps = 192
        [volume]
        solid = [0.3, 0.7]
        actuator = [0.0, 0.42]
        [loss]
        window = 16
        [schedule]
        iterations = 12
        horizon = [32, 64]
    ";
    let scene = Scene::parse("errand", scene).unwrap();
    let mut codesign = CoDesign::new(&scene).unwrap();
    let mut progress = codesign.begin(2).unwrap();
    let mirror = codesign.world().lattice().mirror.clone().unwrap();
    while !codesign.is_done(&progress) {
        codesign.iterate(&mut progress);
        let design = codesign.design(&progress);
        let mixtures = design.mixtures();
        let images = mirror.edges.iter().map(|&image| mixtures[image]);
        assert!(
            mixtures.iter().copied().eq(images),
            "{}",
            progress.iteration
        );
    }
    assert!(progress.design.layout().is_some());
}
