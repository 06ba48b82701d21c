//! `tanh` and the force of one edge at the extremes: values and derivatives.

use autodiff::{Dual, Real, gradient_of};
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic_tests::{Bare, StabilityCase, assert_near, number, numbers, stability_cases};
use serde_json::json;

#[test]
fn tanh_and_its_derivative() {
    for case in stability_cases("dtanh") {
        let a = case.number("a");
        let tolerance = case.of_file("tolerance_abs");
        let forward: Dual<f64, 1> = Dual::variable(a, 0).tanh();
        let reverse = gradient_of(|a| a[0].tanh(), &[a])[0];
        let expected = case.number("tanh");
        assert_near(forward.value, expected, tolerance, &a);
        for slope in [forward.tangent[0], reverse] {
            let error = (slope - case.number("dtanh")).abs();
            assert!(slope >= 0.0 && error <= tolerance, "tanh' {a} = {slope}");
        }
    }
}

/// The effect of an edge in one step on the node at its tail, by the vector `d` to its head.
struct Pull {
    bare: Bare,
    d: Vector<f64>,
    /// The factor from a velocity to the force that caused it: mass over time.
    per_kick: f64,
}

impl Pull {
    fn new(case: &StabilityCase) -> Self {
        let kick = &case.case["kick_v_of_mass"];
        let (mass, dt) = (number(kick, "m"), number(kick, "dt"));
        let mut bare = Bare::new(&[([0, 1], case.number("l0"), case.number("k"))], &[mass; 2]);
        bare.physics.dt = dt;
        // A push sends one of the nodes down, a pull the other: no ground may stop them. Vectors
        // of 1e-7 m are exact only beside the origin, from which heights are measured.
        (bare.physics.contact, bare.physics.ground_height) = (ContactLaw::none(), 0.0);
        let d: [f64; 2] = case.numbers("d").try_into().expect("a vector");
        let d = Vector::new(d);
        Self {
            bare,
            d,
            per_kick: mass / dt,
        }
    }

    /// The velocity that the tail is given; the head's is the opposite.
    fn kick<R: Real>(&self, d: Vector<R>) -> Vector<R> {
        let start = State::new([Vector::zero(), d], [Vector::zero(); 2]);
        let v = self.bare.run_to_end(&start, 1).v;
        (v[0] - v[1]) * R::lit(0.5)
    }

    /// The tangent of the force by forward and by reverse mode.
    fn tangents(&self) -> [[[f64; 2]; 2]; 2] {
        let dual = Vector::from_fn(|k| Dual::<f64, 2>::variable(self.d[k], k));
        let forward = self.kick(dual).map(|v| v.tangent).array();
        let reverse = [0, 1].map(|k| {
            let row = gradient_of(
                |d| self.kick(Vector::new([d[0], d[1]]))[k],
                self.d.as_slice(),
            );
            [row[0], row[1]]
        });
        [forward, reverse].map(|tangent| tangent.map(|row| row.map(|t| t * self.per_kick)))
    }
}

fn check_force(case: &StabilityCase) {
    let pull = Pull::new(case);
    let kick = pull.kick(pull.d);
    let expected = numbers(&case.case["kick_v_of_mass"]["v"]);
    let force = case.numbers("force_on_i");
    // The file's tolerance; near the rest length the difference of the two loses digits.
    let tolerance = case.of_file("tolerance_rel");
    let lost = 1e-13 * case.number("k") * case.number("l0");
    let bound = tolerance * force[0].hypot(force[1]) + lost;
    for k in 0..2 {
        let got = kick[k] * pull.per_kick;
        for expected in [force[k], expected[k] * pull.per_kick] {
            assert!((got - expected).abs() <= bound, "{got}: {}", case.case);
        }
    }
}

#[test]
fn forces_and_kicks() {
    stability_cases("tangent_dF_dd")
        .iter()
        .for_each(check_force);
}

/// Whichever way an edge lies, stretched or compressed.
#[test]
fn edges_push_and_pull_in_every_direction() {
    for [x, y] in [
        [0.3, 0.4],
        [0.3, -0.4],
        [-0.03, 0.04],
        [0.0, -0.2],
        [0.5, 0.0],
    ] {
        let (k, rest, mass, dt) = (400.0, 0.1, 0.02, 0.001);
        let along = k * (1.0 - rest / f64::sqrt(x * x + y * y + 1e-12));
        let force = [along * x, along * y];
        check_force(&StabilityCase {
            file: json!({ "tolerance_rel": 1e-12 }),
            case: json!({
                "d": [x, y], "k": k, "l0": rest, "force_on_i": force,
                "kick_v_of_mass": { "m": mass, "dt": dt, "v": force.map(|f| f * dt / mass) },
            }),
        });
    }
}

#[test]
fn tangents_of_forces() {
    for case in stability_cases("tangent_dF_dd") {
        let expected = case.numbers("tangent_dF_dd");
        let size = expected.iter().fold(0.0, |m: f64, t| m.max(t.abs()));
        let bound = case.of_file("tolerance_rel") * size;
        for mode in Pull::new(&case).tangents() {
            for (got, expected) in mode.as_flattened().iter().zip(&expected) {
                assert_near(*got, *expected, bound, &case.case);
            }
        }
    }
}

/// What one step makes of a small displacement across the edge: the two nodes' kicks by it, for
/// the time of the step.
#[test]
fn transverse_amplification() {
    for case in stability_cases("tangent_dF_dd") {
        let pull = Pull::new(&case);
        let length = pull.d.norm();
        let across = match length {
            0.0 => [0.0, 1.0],
            _ => [-pull.d[1] / length, pull.d[0] / length],
        };
        let dt = pull.bare.physics.dt;
        for tangent in pull.tangents() {
            let by_across = tangent.map(|row| row[0] * across[0] + row[1] * across[1]);
            let force = by_across[0] * across[0] + by_across[1] * across[1];
            let got = 1.0 - 2.0 * dt * force / pull.per_kick;
            let expected = case.number("transverse_amplification_per_step");
            let tolerance = case.of_file("tolerance_rel");
            assert_near(got / expected, 1.0, tolerance, &case.case);
        }
    }
}
