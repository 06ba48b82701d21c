use crate::small::lattice;
use cosmic::design::Design;
use cosmic::design::Material::{Actuator, Skeleton, Void};
use cosmic::lattice::Body;
use cosmic::projection::{Projection, Projector};
use cosmic::scene::{MovedBody, ProjectionSettings, Scene};

#[test]
fn a_void_edge_of_a_layout_has_exactly_the_void_stiffness() {
    let (scene, lattice) = (Scene::paper(), lattice(2, 2, 0.0));
    let layout = Design::Layout(vec![Void, Skeleton, Actuator, Void, Void, Void]);
    let body: Body<f64> = Body::new(&layout, &lattice, &scene.materials, &scene.physics);
    assert_eq!(body.stiffness[..3], [1e-7, 4e2, 3e1]);
    assert_eq!(body.strain[..3], [0.0, 0.0, 0.35]);
    let weight: f64 = body.mass.iter().sum();
    let diagonal = 0.02f64.sqrt();
    let edges = 0.1 * 0.030 + diagonal * 0.1 + 1e-8 * (0.3 + diagonal);
    // The two sums differ by at most twelve rounding errors of numbers below 0.1, each at most 7e-18.
    assert!((weight - (4e-4 + 0.03 + edges)).abs() < 1e-16);
}

/// The payload is always present. Another node is present if it has a bar.
#[test]
fn nodes_without_a_bar_have_no_weight() {
    let (scene, mut lattice) = (Scene::paper(), lattice(3, 2, 0.0));
    lattice.payload[0].node = 3;
    let bar = lattice.edges.iter().position(|ends| *ends == [1, 2]);
    let mut layout = vec![Void; lattice.edges.len()];
    layout[bar.unwrap()] = Skeleton;
    let layout = Design::Layout(layout);
    let marker = |moved, one_piece| {
        let mut body: Body<f64> = Body::new(&layout, &lattice, &scene.materials, &scene.physics);
        if one_piece {
            body = body.with_presence(&layout, layout.layout(), &lattice);
        }
        let mass = body.mass.clone();
        let body = body.with_marker(moved, &layout, layout.layout(), &lattice);
        (body.marker, mass)
    };
    let presence = [0.0, 1.0, 1.0, 1.0, 0.0, 0.0];
    for one_piece in [false, true] {
        assert_eq!(marker(MovedBody::Nodes, one_piece).0.weights, presence);
        let (marker, mass) = marker(MovedBody::Mass, one_piece);
        let present = |(m, used): (&f64, f64)| if one_piece { m * used } else { *m };
        let expected: Vec<f64> = mass.iter().zip(presence).map(present).collect();
        assert_eq!(marker.weights, expected);
    }
    let (payload, mass) = marker(MovedBody::Payload, false);
    assert_eq!((payload.payload, payload.weights.len()), (3, 0));
    assert!(mass[3] > scene.physics.payload_mass && mass[0] < scene.physics.payload_mass);
}

#[test]
fn the_stability_projection_leaves_equal_edges_undecided() {
    let z = vec![[0.9, 0.1, 0.4]; 3];
    let projector = Projector::free(&ProjectionSettings::default());
    for mixture in projector.mixtures(Projection::Stability, &z) {
        // The mean of three equal numbers has a rounding error. The sharpness of 500 multiplies this error.
        assert!(
            mixture
                .0
                .iter()
                .all(|m: &f64| (m - 1.0 / 3.0).abs() < 1e-13)
        );
    }
}
