//! The sweep of extremes: what is expected of every robot, and what becomes of it.

use cosmic::case::Case;
use cosmic::scene::Scene;
use cosmic::simulator::Grade;
use cosmic_lab::verify::stability::{
    Found, Outcome, Trial, bound_ratio, case_trials, extreme_trials, guard_cost,
};

fn case() -> Case {
    let mut scene = Scene::paper();
    (scene.lattice.columns, scene.lattice.rows) = (3, 2);
    scene.controller.hidden = 2;
    scene.physics.steps = 128;
    Case::of_scene(&scene, 0).expect("any lattice starts so")
}

#[test]
fn every_extreme_ends_as_expected() {
    let trials = [case_trials(&case()), extreme_trials()].concat();
    // The large lattices take minutes of an unoptimised test.
    let small = trials.iter().filter(|t| t.case.lattice.nodes() <= 100);
    let found: Vec<Found> = small.map(Trial::run).collect();
    for row in &found {
        assert!(row.is_ok() && !row.unannounced, "{row:?}");
        assert_eq!(row.is_announced(), !row.expected_stable(), "{row:?}");
    }
    let count = |of: fn(&&Found) -> bool| found.iter().filter(of).count();
    assert!(count(|f| !f.expected_stable()) > 30 && count(|f| f.expected_stable()) > 40);
    assert!(count(|f| f.grade == Grade::Close) > 10);
}

/// A check that finds nothing wrong with what is wrong checks nothing.
#[test]
fn a_wrong_expectation_is_seen() {
    let [own, .., twice] = &case_trials(&case())[..] else {
        panic!("a case is tried with several time steps")
    };
    let mut stable = own.run();
    assert!(stable.is_ok() && stable.outcome == Outcome::Bounded);
    // Below the limit, and called unstable; above it, and bounded; NaN that nobody told of.
    stable.grade = Grade::Unstable;
    assert!(!stable.is_ok());
    let unstable = twice.run();
    assert!(unstable.is_ok() && matches!(unstable.outcome, Outcome::Diverged(_)));
    for outcome in [Outcome::Bounded, Outcome::Grew] {
        let calm = outcome == Outcome::Bounded;
        let other = Found {
            outcome,
            ..unstable.clone()
        };
        assert_eq!(other.is_ok(), !calm);
    }
    let silent = Found {
        unannounced: true,
        ..unstable
    };
    assert!(!silent.is_ok());
}

#[test]
fn the_bound_is_one_and_not_far_off() {
    let ratio = bound_ratio(60);
    // The power iteration approaches the largest frequency from below.
    assert!(
        ratio.least > 1.0 - 1e-9 && ratio.least <= ratio.median,
        "{ratio:?}"
    );
    // Two nodes that swing against each other reach the bound; a chain of many stays below by a
    // third or so.
    assert!(ratio.median < 1.3 && ratio.most < 1.6, "{ratio:?}");
}

#[test]
fn the_guard_s_cost_is_measured() {
    let cost = guard_cost(&case());
    assert!(cost.plain > 0.0 && cost.guarded > 0.0 && cost.share > -1.0);
}
