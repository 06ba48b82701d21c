use cosmic::design::{Mixture, attract};

#[test]
fn attraction_moves_edges_with_a_clear_material_within_the_range() {
    let mut z = [[0.5, 0.3, 0.2], [0.4, 0.4, 0.2], [0.0, 0.999, 0.001]];
    let mixtures = [[0.95, 0.04, 0.01], [0.5, 0.49, 0.01], [0.0, 1.0, 0.0]].map(Mixture);
    attract(&mut z, &mixtures, 0.9, 0.004);
    assert_eq!(z[0], [0.5 + 0.004, 0.3 - 0.002, 0.2 - 0.002]);
    assert_eq!(z[1], [0.4, 0.4, 0.2]);
    assert_eq!(z[2], [0.0, 1.0, 0.0]);
}
