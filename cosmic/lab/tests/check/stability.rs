use crate::small::small;
use cosmic::case::Case;
use cosmic::geometry::{Dimension, Vector};
use cosmic::scene::{Integrator, Scene};
use cosmic::world::Grade;
use cosmic_lab::check::stability::{Found, Outcome, Trial, case_trials, extreme_trials};
use rayon::prelude::*;

/// Odd robots that are tried only in tests. Each has the number of trials that [`case_trials`] must make for it.
fn odd_robots() -> Vec<(Case, usize)> {
    type Change = fn(&mut Scene);
    let cases: [(Change, usize); 7] = [
        (|scene| scene.physics.steps = 128, 5),
        // The damping of bars has no energy, so the speed of these robots is watched.
        (
            |scene| scene.physics = Scene::load("earth").unwrap().physics,
            5,
        ),
        // Without springs every time step is stable, so there is only the trial with the robot's own time step.
        (|scene| scene.materials.stiffness = [0.0; 3], 1),
        // In its world, nothing moves this robot.
        (
            |scene| (scene.physics.gravity, scene.materials.max_strain) = (0.0, [0.0; 3]),
            5,
        ),
        // The limit of an implicit step is one of rounding, so only its own time step is tried.
        (|scene| scene.physics.integrator = Integrator::Implicit, 1),
        // The trials have more steps than the case's own rollout.
        (|scene| scene.physics.steps = 1, 5),
        (|scene| scene.physics.steps = 4, 5),
    ];
    let case = |(change, count): &(Change, usize)| (small([3, 2], change), *count);
    let mut robots: Vec<_> = cases.iter().map(case).collect();
    // A robot that starts far from rest is tried only with its own time step.
    for (moved, count) in [(0.9e-2, 5), (1.0, 1)] {
        let mut case = Case::of_scene(&Scene::paper(), 0).unwrap();
        let moved = moved * case.lattice.rest_length[0];
        case.start.x[1] -= Vector::upright(moved, 0.0);
        robots.push((case, count));
    }
    robots
}

#[test]
fn every_extreme_ends_as_expected() {
    let mut trials = [Dimension::Plane, Dimension::Space]
        .map(extreme_trials)
        .concat();
    // Large lattices are left out, because they take minutes without optimisation.
    trials.retain(|trial| trial.case.lattice.nodes() <= 100);
    for (case, count) in odd_robots() {
        let of_case = case_trials(&case);
        assert_eq!(of_case.len(), count);
        trials.extend(of_case);
    }
    let found: Vec<Found> = trials.par_iter().map(Trial::run).collect();
    for row in &found {
        assert!(row.is_ok() && !row.unannounced, "{row:?}");
        let diverged = matches!(row.outcome, Outcome::Diverged(_));
        assert!(!diverged || row.grade == Grade::Unstable, "{row:?}");
    }
    let count = |of: fn(&&Found) -> bool| found.iter().filter(of).count();
    assert!(count(|f| !f.expected_stable()) > 30 && count(|f| f.expected_stable()) > 40);
    assert!(count(|f| f.grade == Grade::Close) > 10);
}

/// A trial fails if the motion is not as expected.
#[test]
fn a_wrong_expectation_is_found() {
    let [own, .., twice] = &case_trials(&small([3, 2], |_| ()))[..] else {
        panic!("a case is tried with several time steps")
    };
    let mut stable = own.run();
    assert!(stable.is_ok() && stable.outcome == Outcome::Bounded);
    // A time step below the limit that was called unstable beforehand.
    stable.grade = Grade::Unstable;
    assert!(!stable.is_ok());
    // A time step above the limit with three outcomes: a bounded motion, a motion that grew, and a NaN that no
    // divergence reported.
    let unstable = twice.run();
    assert!(unstable.is_ok() && matches!(unstable.outcome, Outcome::Diverged(_)));
    for (outcome, unannounced, ok) in [
        (Outcome::Bounded, false, false),
        (Outcome::Grew, false, true),
        (unstable.outcome.clone(), true, false),
    ] {
        let other = Found {
            outcome,
            unannounced,
            ..unstable.clone()
        };
        assert_eq!(other.is_ok(), ok, "{other:?}");
    }
}
