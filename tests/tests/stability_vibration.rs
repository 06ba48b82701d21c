//! Vibrations: one oscillator, chains of extreme stiffness and mass, and the time steps with
//! which they stay bounded.

use cosmic::geometry::{Vector, from_flat};
use cosmic::lattice::State;
use cosmic::scene::PhysicsSettings;
use cosmic::simulator::stability::{Vibration, phase_limit, step_limit};
use cosmic_tests::{Bare, StabilityCase, assert_near, numbers, stability_cases};

/// Two nodes of unit mass to either side of the origin, so that the extension of
/// their spring swings with the case's frequency.
struct Oscillator {
    bare: Bare,
}

/// Length of the oscillator's spring, m: long enough for the softening to be as good as linear, and
/// short enough for positions to be rounded finely.
const LENGTH: f64 = 4.0;

impl Oscillator {
    fn new(case: &StabilityCase) -> Self {
        let omega = case.number("omega");
        // Relative motion of two masses m has omega^2 = 2 k / m. The softening of the length (D4)
        // changes rest and slope of the force by some 1e-12, which is taken back here.
        let squared = LENGTH * LENGTH + 1e-12;
        let (rest, k) = (
            squared.sqrt(),
            0.5 * omega * omega * squared / (LENGTH * LENGTH),
        );
        let mut bare = Bare::new(&[([0, 1], rest, k)], &[1.0, 1.0]);
        bare.physics.dt = case.number("dt");
        bare.physics.damping = case.number("gamma");
        Self { bare }
    }

    /// Extensions and their speeds after so many steps.
    fn run(&self, [x, v]: [f64; 2], steps: &[usize]) -> Vec<[f64; 2]> {
        let half = 0.5 * (LENGTH + x);
        let start = State::new(
            vec![[-half, 0.0], [half, 0.0]],
            vec![[-0.5 * v, 0.0], [0.5 * v, 0.0]],
        );
        let seen = self.bare.run(&start, steps.to_vec());
        let extension = |s: &State<f64>| {
            let [x, v] = [&s.x, &s.v].map(|of| (of[1] - of[0]).forward());
            [x - LENGTH, v]
        };
        seen.states.iter().map(extension).collect()
    }

    /// The modulus of the step's larger eigenvalue, from the step's own matrix.
    fn spectral_radius(&self, amplitude: f64) -> f64 {
        let column = |start: [f64; 2]| self.run(start, &[1])[0].map(|c| c / amplitude);
        let ([a, c], [b, d]) = (column([amplitude, 0.0]), column([0.0, amplitude]));
        let (trace, determinant) = (a + d, a * d - b * c);
        let discriminant = 0.25 * trace * trace - determinant;
        if discriminant < 0.0 {
            return determinant.sqrt();
        }
        0.5 * trace.abs() + discriminant.sqrt()
    }
}

#[test]
fn oscillators_follow_the_map() {
    for case in stability_cases("eigenvalues") {
        let oscillator = Oscillator::new(&case);
        let start = [case.number("x0"), case.number("v0")];
        let rows = case.numbers("trajectory_step_x_v");
        let rows: &[[f64; 3]] = rows.as_chunks().0;
        let steps: Vec<usize> = rows.iter().map(|row| row[0] as usize).collect();
        let seen = oscillator.run(start, &steps);
        let stable = case.case["stable"] == true;
        // Of the amplitude, not of what damping has left of it: positions are rounded at 1e-17.
        let tolerance = case.of_file("tolerance_rel");
        let scale = [start[0], start[0] * case.number("omega").max(1.0)];
        for (got, row) in seen.iter().zip(rows).filter(|_| stable) {
            let error = [0, 1].map(|k| (got[k] - row[1 + k]).abs() / scale[k]);
            let peak = rows
                .iter()
                .fold(start[0], |m: f64, row| m.max(row[1].abs()))
                / start[0];
            assert!(
                error.iter().all(|e| *e <= tolerance * peak),
                "{row:?}: {got:?}"
            );
        }
        if !stable {
            let last = seen.last().expect("a case lists states")[0];
            assert!(last.abs() > 10.0 * start[0], "{}", case.case);
        }
    }
}

#[test]
fn the_step_has_the_eigenvalues_of_the_map() {
    for case in stability_cases("eigenvalues") {
        let got = Oscillator::new(&case).spectral_radius(1e-3);
        let expected = case.number("spectral_radius");
        // Two nearly equal eigenvalues are the root of the difference of entries that are rounded
        // at 1e-13 of the amplitude.
        assert!((got - expected).abs() < 1e-6, "{got} for {expected}");
        let limit = phase_limit(case.number("gamma"), case.number("dt"));
        assert!((limit - case.number("limit_dt_omega")).abs() < 1e-14);
        let stable = case.number("dt") * case.number("omega") < limit;
        assert_eq!(case.case["stable"], stable);
    }
}

/// A chain along the x axis.
fn chain(case: &StabilityCase) -> Bare {
    let (k, rest) = (case.numbers("k"), case.numbers("rest"));
    let springs: Vec<_> = (0..k.len()).map(|e| ([e, e + 1], rest[e], k[e])).collect();
    let mut bare = Bare::new(&springs, &case.numbers("m"));
    bare.physics.dt = case.number("dt");
    bare.physics.damping = case.number("gamma");
    bare
}

/// Positions with every spring at rest.
fn rest_positions(case: &StabilityCase) -> Vec<f64> {
    let mut at = 0.0;
    let mut positions = vec![at];
    for rest in case.numbers("rest") {
        at += rest;
        positions.push(at);
    }
    positions
}

fn largest(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(0.0, |largest, x| largest.max(x.abs()))
}

#[test]
fn chains_of_extreme_stiffness_and_mass() {
    for case in stability_cases("rest") {
        let bare = chain(&case);
        let on_axis = |xs: Vec<f64>| xs.into_iter().map(|x| [x, 0.0]);
        let start = State::new(on_axis(case.numbers("x0")), on_axis(case.numbers("v0")));
        let rest = rest_positions(&case);
        let off_rest = |x: &[Vector<f64>]| largest(x.iter().zip(&rest).map(|(x, r)| x[0] - r));
        let perturbation = off_rest(&start.x);
        let steps = case.number("steps") as usize;
        if case.number("dt_over_limit") > 1.0 {
            let end = bare.run_to_end(&start, steps);
            assert!(off_rest(&end.x) > 1e3 * perturbation, "{}", case.case);
            continue;
        }
        let bound = case.of_file("tolerance_rel_of_perturbation") * perturbation;
        for state in case.case["states"]
            .as_array()
            .expect("a chain lists states")
        {
            let got = bare.run_to_end(&start, state["step"].as_u64().expect("a step") as usize);
            let expected = numbers(&state["x"]);
            let error = largest(got.x.iter().zip(&expected).map(|(x, e)| x[0] - e));
            assert_near(error, 0.0, bound, &state["step"]);
            let speed = numbers(&state["v"]);
            let error = largest(got.v.iter().zip(&speed).map(|(v, e)| v[0] - e));
            // The same error of the fastest vibration.
            assert!(error <= bound * case.number("omega_max"), "{error:e}");
        }
    }
}

#[test]
fn limits_of_chains() {
    for case in stability_cases("rest") {
        let bare = chain(&case);
        let at_rest: Vec<_> = rest_positions(&case)
            .into_iter()
            .map(|x| Vector::new([x, 0.0]))
            .collect();
        let physics = PhysicsSettings::default();
        let vibration = Vibration::new(&bare.lattice, &bare.body, &physics, &at_rest);
        let omega = vibration.largest_frequency();
        let expected = case.number("omega_max");
        // The softening is 1e-12 of a length squared of 1e-2.
        assert_near(omega / expected, 1.0, 1e-9, &case.case["name"]);
        // The file takes the damping of a step from the case's own time step.
        let limit = phase_limit(case.number("gamma"), case.number("dt")) / expected;
        let error = (limit / case.number("limit_dt") - 1.0).abs();
        assert!(error < 1e-14, "{}: {error:e}", case.case["name"]);
    }
}

#[test]
fn stable_steps_of_lattices() {
    for case in stability_cases("omega_bound_edge") {
        let lattice = case.lattice(case.edges());
        let physics = PhysicsSettings {
            node_mass: case.number("m_eps"),
            payload_mass: case.number("payload_mass"),
            ..PhysicsSettings::default()
        };
        let body = case.body(&lattice, &physics);
        let positions = from_flat(&case.numbers("positions"));
        let vibration = Vibration::new(&lattice, &body, &physics, &positions);
        let tolerance = case.of_file("tolerance_rel");
        let check = |key: &str, got: f64| {
            let expected = case.number(key);
            assert_near(got / expected, 1.0, tolerance, &key);
        };
        let gamma = case.number("gamma");
        check("omega_bound_edge", vibration.edge_bound());
        check("omega_bound_node", vibration.node_bound());
        check("omega_max", vibration.largest_frequency());
        let exact = step_limit(vibration.largest_frequency(), gamma, 0.0);
        check("dt_limit_exact", exact);
        let from_bound = step_limit(vibration.edge_bound(), gamma, 0.0);
        check("dt_limit_from_bound", from_bound);
    }
}
