use cosmic_optimiser::mma::solve_positive;

#[test]
fn a_positive_system_is_solved() {
    let mut right = [8.0, 15.0, 5.0];
    solve_positive(
        &mut [4.0, 2.0, 0.0, 2.0, 5.0, 1.0, 0.0, 1.0, 1.0],
        &mut right,
    );
    // The solution is (1, 2, 3). The factors of the decomposition are exact to a few ulps.
    for (found, expected) in right.iter().zip([1.0, 2.0, 3.0]) {
        assert!((found - expected).abs() < 1e-14, "{right:?}");
    }
}

#[test]
fn a_singular_system_has_a_finite_solution() {
    let mut right = [1.0, 1.0];
    solve_positive(&mut [1.0, 1.0, 1.0, 1.0], &mut right);
    // The first equation holds up to the rounding of numbers of the size 1 / epsilon^(1/2).
    assert!((right[0] + right[1] - 1.0).abs() < 1e-6, "{right:?}");
}
