use cosmic::geometry::Vector;
use cosmic_lab::export::joint::{around, corners_at};

#[test]
fn a_joint_has_a_side_for_each_strut_and_is_closed() {
    use std::f64::consts::FRAC_PI_4;
    for angles in [
        vec![0.3],
        vec![-2.0, 1.0],
        vec![0.0, FRAC_PI_4, 2.0 * FRAC_PI_4],
        (0..8).map(|k| k as f64 * FRAC_PI_4 - 3.0).collect(),
    ] {
        let corners = around(angles.clone(), 2.0);
        assert!(corners.len() >= angles.len().max(4));
        for angle in angles {
            let along = |corner: &Vector<f64>| corner.dot(Vector::at_angle(angle));
            // No corner lies beyond the side, and exactly two corners lie on it.
            let on_it = corners.iter().filter(|c| (along(c) - 2.0).abs() < 1e-12);
            assert_eq!(on_it.count(), 2);
            assert!(corners.iter().all(|corner| along(corner) < 2.0 + 1e-12));
        }
    }
}

#[test]
fn a_polygon_has_the_area_of_its_circle() {
    let (sides, far) = (24, corners_at(24));
    let angle = std::f64::consts::TAU / sides as f64;
    let area = 0.5 * sides as f64 * far * far * angle.sin();
    assert!((area - std::f64::consts::PI).abs() < 1e-14);
}
