use crate::small::small;
use cosmic::verdict::Level;
use cosmic_lab::verify::distance;
use cosmic_lab::verify::distance::{SAME, most_apart};

/// The distance of a robot in free fall along the ground is 0 for every time step, integrator and precision.
#[test]
fn a_falling_robot_does_not_depend_on_the_time_step() {
    let case = small([2, 2], |scene| {
        (scene.lattice.drop, scene.physics.steps) = (1.0, 64);
        scene.controller.gain = [0.0; 2];
    });
    let section = distance(&case);
    let levels = section.verdict.iter().map(|answer| answer.level);
    assert!(levels.eq([Level::Good; 4]), "{:?}", section.verdict);
    assert_eq!((section.checks, section.failures.len()), (1, 0));
}

#[test]
fn distances_are_compared_with_the_scenes_own() {
    // The numbers of the issue that asked for the question: 2, 1, 0.5 and 0.25 ms.
    let off = most_apart(3.99, [3.99, 4.03, 4.03, 3.96].into_iter(), 0.01);
    assert!((off - 0.04 / 3.99).abs() < 1e-12, "{off}");
    assert_eq!(Level::up_to(SAME, off), Level::Good);
    assert_eq!(
        Level::up_to(SAME, most_apart(4.0, [4.4].into_iter(), 0.01)),
        Level::Doubtful
    );
    assert_eq!(
        Level::up_to(SAME, most_apart(4.0, [5.0].into_iter(), 0.01)),
        Level::Bad
    );
    assert_eq!(most_apart(4.0, [f64::NAN].into_iter(), 0.01), f64::INFINITY);
    // A robot that stays in place: a difference of 1 mm is small compared with 5 cm.
    assert_eq!(most_apart(0.0, [0.001].into_iter(), 0.05), 0.02);
}
