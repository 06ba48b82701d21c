use cosmic::design::{Mixture, attract, vectors_of_mixture};

#[test]
fn vectors_keep_the_ratios_of_the_mixture() {
    let [z] = vectors_of_mixture(&[Mixture([0.6, 0.3, 0.1])], 20.0)[..] else {
        panic!("expected one edge")
    };
    // exp(20 x) multiplies the rounding error of z, 1e-16, by 20.
    let ratio = |k: usize, l: usize| (20.0 * (z[k] - z[l])).exp();
    assert!((ratio(0, 1) - 2.0).abs() < 1e-13 && (ratio(0, 2) - 6.0).abs() < 1e-13);
    assert!((z.iter().sum::<f64>() - 1.0).abs() < 1e-15);
}

#[test]
fn attraction_moves_edges_with_a_clear_material_within_the_range() {
    let mut z = [[0.5, 0.3, 0.2], [0.4, 0.4, 0.2], [0.0, 0.999, 0.001]];
    let mixtures = [[0.95, 0.04, 0.01], [0.5, 0.49, 0.01], [0.0, 1.0, 0.0]].map(Mixture);
    attract(&mut z, &mixtures, 0.9, 0.004);
    assert_eq!(z[0], [0.5 + 0.004, 0.3 - 0.002, 0.2 - 0.002]);
    assert_eq!(z[1], [0.4, 0.4, 0.2]);
    assert_eq!(z[2], [0.0, 1.0, 0.0]);
}
