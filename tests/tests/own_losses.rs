//! Objectives of a user: they read the payload, whichever node it is.

#[path = "../../cosmic/program/examples/ride.rs"]
#[expect(dead_code, reason = "only its loss is used")]
mod ride;

use autodiff::check::Verdict;
use cosmic::case::Case;
use cosmic::objective::Loss;
use cosmic::scene::Scene;
use cosmic::world::{Span, Trajectory};
use cosmic_lab::check::check_gradients_of;
use cosmic_tests::{few_directions, workspace};
use ride::Ride;

/// Robots that fall on the ground, whose payloads are not node 0.
fn robots() -> impl Iterator<Item = (&'static str, Case)> {
    let small = [
        (
            "cube",
            "lattice.columns = 2\nlattice.depth = 3\nlattice.rows = 2",
        ),
        ("errand", "lattice.columns = 3\nlattice.rows = 2"),
        (
            "stability",
            "lattice.columns = 3\nlattice.rows = 2\nlattice.payload = 4",
        ),
    ];
    small.into_iter().map(|(base, lattice)| {
        let text = format!(
            "base = '{base}'\n{lattice}\nlattice.drop = 0.01\ncontroller.hidden = 6\nphysics.steps = 64"
        );
        let case = Case::of_scene(&Scene::parse(base, &text).unwrap(), 1).unwrap();
        assert_ne!(case.lattice.payload[0].node, 0, "{base}");
        (base, case)
    })
}

fn rollout(case: &Case, observed: Vec<usize>) -> Trajectory<f64> {
    (case.world()).run_one(&case.robot(), &Span::from_start(observed))
}

#[test]
fn the_payload_of_a_trajectory_is_that_of_the_lattice() {
    for (name, case) in robots() {
        let payload = case.lattice.payload[0].node;
        let seen = rollout(&case, vec![0, 32, 64]);
        for (k, state) in seen.states.iter().enumerate() {
            assert_eq!(seen.payload(k).x, state.x[payload], "{name}");
            assert_eq!(seen.payload(k).v, state.v[payload], "{name}");
        }
        assert_ne!(seen.payload(1).x, seen.states[1].x[0], "{name}");
    }
}

/// The loss of the example `ride` has the value and the gradient of the payload's ride, also where states hold few nodes.
#[test]
fn a_ride_is_that_of_the_payload() {
    for (name, case) in robots() {
        let seen = rollout(&case, Ride.observed(64));
        let ride = |node: usize| {
            let states = seen.states.iter();
            let shaking: f64 = states.map(|state| state.v[node].up().powi(2)).sum();
            let [start, end] = [0, 64].map(|step| seen.at(step).x[node].forward());
            shaking / seen.states.len() as f64 - (end - start)
        };
        let loss = Ride.loss(&seen);
        // A sum of five squares of order one.
        assert!(
            (loss - ride(case.lattice.payload[0].node)).abs() < 1e-14,
            "{name}"
        );
        assert!((loss - ride(0)).abs() > 1e-6, "{name}");
        let check = check_gradients_of(&Ride, &case, 48, &few_directions());
        for group in &check.groups {
            assert_eq!(group.verdict, Verdict::Smooth, "{name}, {}", group.report);
        }
    }
}

/// The objectives that users copy do not read a node by its number.
#[test]
fn objectives_to_copy_read_the_payload() {
    for path in ["docs/extending.md", "cosmic/program/examples/ride.rs"] {
        let text = std::fs::read_to_string(workspace().join(path)).unwrap();
        assert!(text.contains(".payload(k)."), "{path}");
        assert!(!text.contains("x[0]") && !text.contains("v[0]"), "{path}");
    }
}
