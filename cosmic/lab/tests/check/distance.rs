use crate::small::small;
use cosmic::judge::verdict::Level;
use cosmic::laws::ContactLaw;
use cosmic_lab::check::distance;
use cosmic_lab::check::distance::{Reference, SAME};

/// The distance of a robot in free fall along the ground is 0 for every time step, integrator and precision.
#[test]
fn a_robot_that_hardly_moves_is_told_so() {
    let case = small([2, 2], |scene| {
        (scene.lattice.drop, scene.physics.steps) = (1.0, 64);
        scene.controller.gain = [0.0; 2];
    });
    let section = distance(&case, true);
    // A robot that does not move says nothing about the time step.
    let [answer] = &section.answers[..] else {
        panic!("{:?}", section.answers);
    };
    assert_eq!(answer.level, Level::Doubtful);
    assert!(
        answer.text.contains("hardly moves: 0.000 m in 0.13 s"),
        "{answer:?}"
    );
    // The robot does not diverge, at half the time step, and with leapfrog.
    assert_eq!((section.checks, section.failures.len()), (3, 0));
    assert_eq!(distance(&case, false).checks, 1);
}

/// A robot flies along the ground and is damped so strongly that a step is too long for the decay of its velocity. For a
/// delivered robot that is a failure, for a scene it is only printed.
#[test]
fn a_delivered_robot_whose_distance_depends_on_the_time_step_fails() {
    let mut case = small([2, 2], |scene| {
        (scene.physics.contact, scene.physics.steps) = (ContactLaw::none(), 64);
        (scene.physics.dt, scene.physics.damping) = (0.002, 500.0);
        scene.controller.gain = [0.0; 2];
    });
    case.start.v.fill([100.0, 0.0].into());
    let [scene, delivered] = [false, true].map(|is_delivered| distance(&case, is_delivered));
    assert_eq!(scene.answers, delivered.answers);
    assert_eq!(scene.answers[1].level, Level::Bad, "{:?}", scene.answers);
    assert!(scene.failures.is_empty(), "{:?}", scene.failures);
    // A velocity that falls by a factor of e in each step covers 58 % of the way, with half the step 77 %.
    let half = "half the time step changes the distance by 32 %";
    assert_eq!(delivered.failures[0], half, "{delivered:?}");
}

#[test]
fn distances_are_compared_with_the_scenes_own() {
    // The medians of a robot at 2, 1, 0.5 and 0.25 ms.
    let level = |median: f64, distances: &[f64]| {
        let compare = Reference {
            median,
            least: 0.01,
        };
        let off = distances.iter().map(|distance| compare.off(*distance));
        Level::up_to(SAME, off.fold(0.0, f64::max))
    };
    assert_eq!(level(3.99, &[3.99, 4.03, 4.03, 3.96]), Level::Good);
    assert_eq!(level(4.0, &[4.4]), Level::Doubtful);
    assert_eq!(level(4.0, &[5.0]), Level::Bad);
    let compare = |median, least| Reference { median, least };
    assert_eq!(compare(4.0, 0.01).off(f64::NAN), f64::INFINITY);
    // A robot that moves at one of the time steps is compared.
    let hardly = |medians: [f64; 2]| compare(0.0, 0.05).hardly_moves(medians);
    assert!(hardly([0.049, -0.049]) && !hardly([0.0, 0.051]) && !hardly([0.0, f64::NAN]));
    // A robot that stays in place: a difference of 1 mm is small compared with 5 cm.
    assert_eq!(compare(0.0, 0.05).off(0.001), 0.02);
}
