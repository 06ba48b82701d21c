//! Dropped lattices come to rest on the ground, or slide, over a hundred thousand steps.

use cosmic::geometry::{Ground, Vector, from_flat};
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::scene::PhysicsSettings;
use cosmic::simulator::Trajectory;
use cosmic_tests::{Bare, StabilityCase, stability_cases};

/// A lattice of one material an edge, every actuator idle.
struct Dropped {
    bare: Bare,
    start: State<f64>,
}

impl Dropped {
    fn new(case: &StabilityCase) -> Self {
        let physics = case.world();
        let positions = from_flat(&case.numbers("x0"));
        let lattice = case.lattice_at(positions, case.edges());
        let mut body = case.body(&lattice, &physics);
        body.strain.fill(0.0);
        let start = lattice.state_at_rest();
        Self {
            bare: Bare {
                lattice,
                body,
                physics,
            },
            start,
        }
    }
}

/// True if friction holds the lattice for good.
fn rests(physics: &PhysicsSettings) -> bool {
    let slope = physics.incline_deg.to_radians().tan();
    physics.contact == ContactLaw::infinite() || physics.friction > slope
}

/// The touch-down step by step, and then every hundredth step.
fn observed() -> Vec<usize> {
    (0..20_000).chain((20_000..=100_000).step_by(100)).collect()
}

fn largest_difference(a: &[Vector<f64>], b: &[Vector<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

#[test]
fn lattices_come_to_rest() {
    for case in stability_cases("x_100000") {
        let Dropped { bare, start } = Dropped::new(&case);
        let seen = bare.run(&start, observed());
        let rests = rests(&bare.physics);
        for step in [20_000, 100_000] {
            let expected = case.numbers(&format!("x_{step}"));
            let expected = from_flat(&expected);
            let path = largest_difference(&expected, &start.x);
            let bound = if rests {
                case.of_file("tolerance_abs_resting")
            } else {
                1e-6 * path
            };
            let error = largest_difference(&seen.at(step).x, &expected);
            assert!(
                error <= bound,
                "step {step}: {error:e}, allowed are {bound:e}"
            );
        }
        if rests {
            let moved = largest_difference(&seen.at(20_000).x, &seen.at(100_000).x);
            // Damping leaves nothing after 20 000 steps, and rounding goes to and fro at 1e-17: a
            // creep as slow as a micrometre in hours would show.
            assert!(moved < 1e-8, "it creeps: {moved:e}");
            check_speeds(seen.at(100_000), &Ground::from(&bare.physics));
        }
        check_heights(&seen, &bare.physics);
    }
}

/// Contacts stand still, the rest nearly so; the file's bounds.
fn check_speeds(state: &State<f64>, ground: &Ground) {
    let heights = state.to_ground(ground).x;
    let mut contacts = 0;
    for (x, v) in heights.iter().zip(&state.v) {
        let speed = v.norm();
        // A node on the ground stands on the line to rounding.
        if x.up() < 1e-12 {
            contacts += 1;
            assert_eq!(speed, 0.0);
        }
        assert!(speed < 1e-11, "{speed:e}");
    }
    assert!(contacts > 0, "nothing is on the ground");
}

/// Nothing sinks into the ground.
fn check_heights(seen: &Trajectory<f64>, physics: &PhysicsSettings) {
    let ground = Ground::from(physics);
    for (state, step) in seen.states.iter().zip(&seen.steps) {
        let size = state
            .x
            .iter()
            .flatten()
            .fold(1.0, |m: f64, x| m.max(x.abs()));
        let points = state.to_ground(&ground).x;
        let lowest = points.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        // The file's bound, and what turning coordinates of a hundred metres rounds away.
        assert!(lowest >= -1e-12 * size, "step {step}: {lowest:e}");
    }
}
