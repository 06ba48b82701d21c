use cosmic::judge::Quantiles;

#[test]
fn quantiles_are_linear_between_members() {
    let spread = Quantiles::of(&[4.0, 1.0, 3.0, 2.0, 5.0]);
    assert_eq!((spread.p50, spread.p90), (3.0, 4.6));
    assert!((spread.p10 - 1.4).abs() < 1e-15);
    assert_eq!(Quantiles::of(&[1.0, 2.0, 4.0, 8.0]).p50, 3.0);
}

#[test]
fn a_diverged_rollout_counts_lowest() {
    let spread = Quantiles::of(&[2.0, f64::NAN, 3.0, f64::INFINITY]);
    // Sorted: two diverged rollouts, 2, 3. The median lies between the second and the third.
    assert_eq!(
        (spread.p10, spread.p50),
        (f64::NEG_INFINITY, f64::NEG_INFINITY)
    );
    assert!((spread.p90 - 2.7).abs() < 1e-15);
}
