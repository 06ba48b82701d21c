use cosmic::simulator::rounded_down;

#[test]
fn remedies_have_two_digits_and_are_safe() {
    for (x, expected) in [
        (0.002399, 0.0023),
        (9.99e-5, 9.9e-5),
        (0.1, 0.1),
        (12.0, 12.0),
    ] {
        assert_eq!(rounded_down(x, 2), expected);
    }
    assert_eq!(rounded_down(2.7909e-6, 4), 2.79e-6);
    assert_eq!(rounded_down(2.7899e-6, 4), 2.789e-6);
    assert_eq!(rounded_down(f64::INFINITY, 4), f64::INFINITY);
}
