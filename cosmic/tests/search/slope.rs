use cosmic::search::Slope;

#[test]
fn a_gradient_becomes_its_running_mean() {
    let mut mean = Vec::new();
    let mut averaged = |gradient: &[f64], memory| {
        let mut slope = Slope {
            gradient: gradient.to_vec(),
            ..Slope::default()
        };
        slope.averaged(&mut mean, memory);
        assert!(memory > 0.0 || mean.is_empty());
        slope.gradient
    };
    assert_eq!(averaged(&[1.0, 2.0], 0.0), [1.0, 2.0]);
    assert_eq!(averaged(&[4.0, -8.0], 0.75), [4.0, -8.0]);
    assert_eq!(averaged(&[0.0, 8.0], 0.75), [3.0, -4.0]);
    // A gradient that is not finite is returned unchanged and does not enter the mean.
    assert_eq!(averaged(&[f64::INFINITY, 1.0], 0.75), [f64::INFINITY, 1.0]);
    assert_eq!(averaged(&[3.0, -4.0], 0.75), [3.0, -4.0]);
}
