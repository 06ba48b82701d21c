use cosmic::geometry::{Range, Vector};
use cosmic_lab::report::plot::{Axes, Axis, decades, number, range, round_values};

#[test]
fn marks_are_round_and_inside() {
    assert_eq!(
        round_values(Range::new(0.0, 300.0), 8),
        [0.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0]
    );
    assert_eq!(
        round_values(Range::new(-0.9, 1.1), 4),
        [-0.5, 0.0, 0.5, 1.0]
    );
    assert_eq!(decades(Range::new(0.02, 500.0)), [0.1, 1.0, 10.0, 100.0]);
    assert_eq!(
        [0.1 + 0.2, -2.0, 0.0, 1e-6, 12345.0].map(number),
        ["0.3", "\u{2212}2", "0", "1e-6", "12345"]
    );
}

#[test]
fn a_range_has_width_and_ignores_what_is_not_finite() {
    let numbers = [1.0, f64::NAN, f64::INFINITY, 3.0].into_iter();
    let two = Range::new(2.0, 2.0);
    assert_eq!(range(numbers, two), Range::new(1.0, 3.0));
    assert_eq!(range([].into_iter(), two), Range::new(1.5, 2.5));
}

#[test]
fn points_are_placed_from_the_lower_left() {
    let axes = Axes {
        origin: Vector::new([10.0, 20.0]),
        size: Vector::new([100.0, 50.0]),
        x: Axis::linear(Range::new(0.0, 4.0)),
        y: Axis::logarithmic(Range::new(1.0, 100.0)),
    };
    let middle = Vector::new([60.0, 45.0]);
    // The tolerance allows the rounding errors of quotients of logarithms, 1e-16, times 50 pixels.
    assert!(axes.place(Vector::new([2.0, 10.0])).distance(middle) < 1e-12);
    assert_eq!(axes.place(Vector::new([9.0, 0.0])), [110.0, 70.0]);
    let both = Axes {
        x: Axis::logarithmic(Range::new(1e-2, 1.0)),
        ..axes
    };
    assert!(both.place(Vector::new([0.1, 10.0])).distance(middle) < 1e-12);
}
