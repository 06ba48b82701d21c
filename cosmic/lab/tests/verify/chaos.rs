use crate::small::small;
use cosmic_lab::verify::chaos::{Chaos, growth_rate, largest_growth};

#[test]
fn growth_is_read_from_small_distances_only() {
    let steps: Vec<usize> = (0..100).map(|k| 8 * k).collect();
    let grown = |n: &usize| (1e-9 * (*n as f64 / 40.0).exp2()).min(0.3);
    let distances: Vec<f64> = steps.iter().map(grown).collect();
    // Expected rounding: the logarithms are near 20, so each has an error of 4e-15. The fit averages over hundreds
    // of steps.
    assert!((growth_rate(&steps, &distances) - 1.0 / 40.0).abs() < 1e-12);
    assert_eq!(growth_rate(&steps[..3], &[f64::NAN; 3]), 0.0);
    let parting = [vec![1e-9, 4e-9, 2e-9, 1e-3], vec![1e-9, 1e-9, 8e-9, 9e-9]];
    let grown = largest_growth(&[0, 8, 16, 24], &parting);
    assert_eq!(grown, [(0, 1.0), (8, 4.0), (16, 8.0)]);
}

/// If its controller does nothing, a robot comes to rest from all neighbouring starts, so its motions do not
/// diverge.
#[test]
fn a_resting_robot_is_not_chaotic() {
    let mut chaos = Chaos::of(&small([2, 2], |scene| {
        (scene.controller.gain, scene.physics.steps) = ([0.0; 2], 400);
    }));
    assert_eq!(chaos.doubling, f64::INFINITY);
    assert!(chaos.note().contains("do not double"));
    // The payload moves only a few micrometres, because the robot sags.
    assert!(chaos.spread.p90 - chaos.spread.p10 < 1e-6, "{chaos:?}");
    // From the last measurement before a step, growth continues at the mean rate.
    (chaos.doubling, chaos.grown) = (10.0, vec![(0, 1.0), (8, 4.0), (16, 8.0)]);
    assert_eq!(chaos.growth(12), 4.0 * 0.4f64.exp2());
    assert_eq!(chaos.growth(36), 8.0 * 4.0);
}
