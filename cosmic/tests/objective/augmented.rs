use cosmic::objective::AugmentedLagrangian;

#[test]
fn penalties_stay_finite() {
    let mut lagrangian = AugmentedLagrangian::new(1.0);
    for step in 1..400 {
        let now = 1.0 - (-f64::from(step)).exp2().max(1e-12);
        lagrangian.update(&[now; 4], &[0.0; 4], 10.0);
    }
    assert!(lagrangian.objective(0.0_f64, [1.0; 4]).is_finite());
}

#[test]
fn multipliers_move_with_the_old_penalties() {
    let mut lagrangian = AugmentedLagrangian::new(0.5);
    lagrangian.update(&[0.5, 0.25, 0.25, 0.0], &[0.25, 0.5, 0.25, 0.0], 2.0);
    assert_eq!(lagrangian.multiplier, [-0.25, -0.125, -0.125, 0.0]);
    assert_eq!(lagrangian.penalty, [1.0, 0.25, 0.5, 0.5]);
}

#[test]
fn a_small_penalty_can_grow_again() {
    let mut lagrangian = AugmentedLagrangian::new(1.0);
    for _ in 0..400 {
        lagrangian.update(&[0.0; 4], &[1.0; 4], 10.0);
    }
    let least = lagrangian.penalty[0];
    lagrangian.update(&[1.0; 4], &[0.0; 4], 10.0);
    assert!(least > 0.0 && lagrangian.penalty[0] > 9.0 * least);
}
