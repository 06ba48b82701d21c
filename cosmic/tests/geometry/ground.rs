use cosmic::geometry::{Ground, Vector};

#[test]
fn conversion_to_the_ground_s_frame_and_back() {
    for incline_deg in [-37.0, 0.0, 15.0, 90.0] {
        let ground = Ground { incline_deg };
        let point: Vector<f64> = [0.7, -0.3].into();
        let back = ground.vector_to_world(ground.vector_to_ground(point));
        // Two rotations of numbers below 1 have a few roundings of 1e-16.
        assert!(back.distance(point) < 1e-15);
    }
}

#[test]
fn the_normal_points_out_of_the_ground() {
    let ground = Ground { incline_deg: 30.0 };
    let up = ground.vector_to_ground(ground.normal() * 2.0);
    // The tolerance covers the rounding of one rotation of numbers near 2.
    assert!(up.distance(Vector::from([0.0, 2.0])) < 1e-15);
}

#[test]
fn flat_ground_is_exact() {
    let ground = Ground { incline_deg: 0.0 };
    assert_eq!(ground.tangent(), [1.0, 0.0]);
    assert_eq!(ground.normal(), [0.0, 1.0]);
}
