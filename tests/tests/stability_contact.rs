//! Single nodes: flight, the ground met at the edges of a step, friction on an incline, and the
//! derivative of where a bounce ends.

use autodiff::{Dual, Real, gradient_of};
use cosmic::geometry::Ground;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::scene::PhysicsSettings;
use cosmic::simulator::Trajectory;
use cosmic_tests::{Bare, StabilityCase, assert_near, number, stability_cases, stability_lists};
use serde_json::{Value, json};

/// The world of a case, with a ground at height zero that has this contact.
fn on_ground(case: &StabilityCase, contact: ContactLaw) -> PhysicsSettings {
    PhysicsSettings {
        contact,
        ground_height: 0.0,
        ..case.world()
    }
}

/// The free node of a world and its companion, both in the same state.
fn alone<R: Real>(x: [R; 2], v: [R; 2]) -> State<R> {
    State::new([x; 2], [v; 2])
}

/// The node's own numbers `[x, y, vx, vy]`.
fn node<R: Real>(state: &State<R>) -> [R; 4] {
    [state.x[0][0], state.x[0][1], state.v[0][0], state.v[0][1]]
}

fn check_flight(case: &StabilityCase) {
    let bare = Bare::free_node(case.world());
    let start = alone(
        [0.0, case.number("y0")],
        [case.number("vx"), case.number("vy")],
    );
    let end = bare.run_to_end(&start, case.number("steps") as usize);
    let tolerance = case.of_file("tolerance_rel");
    let [x, y, vx, vy] = node(&end);
    let v = case.numbers("v");
    let pairs = [
        (x, case.number("x")),
        (y, case.number("y")),
        (vx, v[0]),
        (vy, v[1]),
    ];
    for (got, expected) in pairs {
        // A velocity that damping took away is compared in the size of what it was.
        let error = (got - expected).abs() / expected.abs().max(1e-3);
        assert!(error <= tolerance, "{got} for {expected}: {}", case.case);
    }
    // The error against the parabola: first order in dt, and of that sign. Numbers as large as the
    // way flown are rounded.
    let continuous = case.numbers("continuous");
    let size = continuous.iter().fold(y.abs(), |most, c| most.max(c.abs()));
    for (k, got) in [x, y].into_iter().enumerate() {
        let expected = case.numbers("error")[k];
        assert!((got - continuous[k] - expected).abs() <= tolerance * size);
    }
}

#[test]
fn free_flight() {
    let cases = stability_cases("terminal_velocity_discrete");
    cases.iter().for_each(check_flight);
}

/// A free flight has no ground, however deep it falls.
#[test]
fn a_flight_may_fall_to_any_depth() {
    for (vy, steps) in [(0.0, 100), (-3.0, 1_000), (-500.0, 2_000)] {
        let (vx, gravity, dt) = (2.0, 9.81, 0.01);
        let (n, time) = (f64::from(steps), dt * f64::from(steps));
        let parabola = time * vy - 0.5 * gravity * time * time;
        let below = -0.5 * gravity * dt * time;
        check_flight(&StabilityCase {
            file: json!({ "tolerance_rel": 1e-12 }),
            case: json!({
                "y0": 0.0, "vx": vx, "vy": vy, "gravity": gravity, "gamma": 0.0, "dt": dt,
                "steps": steps, "x": vx * time, "y": parabola + below,
                "v": [vx, vy - gravity * dt * n],
                "continuous": [vx * time, parabola], "error": [0.0, below],
            }),
        });
    }
}

#[test]
fn terminal_velocity() {
    let cases = stability_cases("terminal_velocity_discrete").into_iter();
    let damped: Vec<_> = cases.filter(|case| case.number("gamma") > 0.0).collect();
    assert!(!damped.is_empty(), "no case of a damped flight");
    for case in damped {
        let physics = case.world();
        // After 40 decay times exp(-40) = 4e-18 is left of the start.
        let steps = (40.0 / (physics.damping * physics.dt)).ceil() as usize;
        let end = Bare::free_node(physics).run_to_end(&alone([0.0; 2], [0.0; 2]), steps);
        let expected = case.number("terminal_velocity_discrete");
        let tolerance = case.of_file("tolerance_rel");
        assert_near(end.v[0][1] / expected, 1.0, tolerance, &case.case);
    }
}

/// A contact case, run step by step.
struct Landing {
    physics: PhysicsSettings,
    seen: Trajectory<f64>,
}

impl Landing {
    fn new(case: &StabilityCase) -> Self {
        let physics = case.world();
        let pair = |key: &str| case.numbers(key).try_into().expect("two numbers");
        let steps = case.number("steps") as usize;
        let start = alone(pair("x0"), pair("v0"));
        let seen = Bare::free_node(physics.clone()).run(&start, (0..=steps).collect());
        Self { physics, seen }
    }

    /// The time of impact of a step, from 1, where the node touches in it: it loses the speed
    /// towards the ground that it had, and moved with it until then.
    fn time_of_impact(&self, step: usize) -> Option<f64> {
        let ground = Ground::from(&self.physics);
        let [before, after] = [step - 1, step].map(|s| self.seen.at(s).to_ground(&ground));
        let pull = -(ground.vertical::<2>() * self.physics.gravity).up();
        let decay = (-self.physics.damping * self.physics.dt).exp();
        let towards = decay * before.v[0][1] + pull * self.physics.dt;
        // Speeds are of order one and turned by the incline, which rounds them.
        let touches = towards < -1e-14 && after.v[0][1].abs() < 1e-14;
        touches.then(|| (after.x[0][1] - before.x[0][1]) / towards)
    }
}

#[test]
fn a_node_meets_the_ground() {
    for case in stability_cases("first_touches_step_tau") {
        let name = &case.case["name"];
        let landing = Landing::new(&case);
        let tolerance = case.of_file("tolerance_abs");
        let rows = case.numbers("states_step_x_y_vx_vy");
        for [step, expected @ ..] in rows.as_chunks::<5>().0 {
            let got = node(landing.seen.at(*step as usize));
            let error = |k: usize| (got[k] - expected[k]).abs();
            let close = (0..4).all(|k| error(k) <= tolerance);
            assert!(close, "{name}, step {step}: {got:?} for {expected:?}");
        }
        let touches: Vec<(usize, f64)> = (1..=landing.seen.last_step())
            .filter_map(|step| Some((step, landing.time_of_impact(step)?)))
            .collect();
        let listed = case.numbers("first_touches_step_tau");
        for (k, [step, time]) in listed.as_chunks::<2>().0.iter().enumerate() {
            let (got_step, got_time) = touches[k];
            assert_eq!(got_step, *step as usize, "{name}: touch {k}");
            // A height is rounded at 1e-16 and fallen through at some 0.02 m/s at least.
            assert_near(got_time, *time, 1e-13, name);
        }
    }
}

/// A node that stops at the beginning of a step does not change by a bit.
#[test]
fn a_resting_node_keeps_its_bits() {
    let mut resting = 0;
    for case in stability_cases("first_touches_step_tau") {
        let landing = Landing::new(&case);
        let listed = case.numbers("first_touches_step_tau");
        let at_once = listed[..2] == [1.0, 0.0];
        if at_once && case.case["contact"] == "infinite" && landing.physics.incline_deg == 0.0 {
            resting += 1;
            let start = landing.seen.at(0).x[0];
            assert!(landing.seen.states.iter().all(|state| state.x[0] == start));
        }
    }
    assert!(resting > 0, "no case of a node that stops at once");
}

#[test]
fn friction_on_an_incline_has_the_classical_threshold() {
    for case in stability_cases("slid_down") {
        let physics = on_ground(&case, ContactLaw::coulomb());
        let ground = Ground::from(&physics);
        let run = |steps| {
            let bare = Bare::free_node(physics.clone());
            bare.run_to_end(&alone([0.0; 2], [0.0; 2]), steps)
                .to_ground(&ground)
        };
        let end = run(case.number("steps") as usize);
        let tolerance = case.of_file("tolerance_abs");
        let (slid, speed) = (-end.x[0][0], -end.v[0][0]);
        assert_near(slid, case.number("slid_down"), tolerance, &case.case);
        assert_near(speed, case.number("speed"), tolerance, &case.case);
        assert_eq!(case.case["slides"], slid != 0.0);
        if let Some(terminal) = case.case["terminal_speed"].as_f64() {
            // As in `terminal_velocity`.
            let steps = (40.0 / (physics.damping * physics.dt)).ceil() as usize;
            assert_near(-run(steps).v[0][0], terminal, tolerance, &case.case);
        }
    }
}

#[test]
fn friction_brakes_to_a_stop() {
    for case in stability_lists("braking", "stops_at_step") {
        let physics = on_ground(&case, ContactLaw::coulomb());
        let start = alone([0.0; 2], [case.number("v0"), 0.0]);
        let stop = case.number("stops_at_step") as usize;
        let seen = Bare::free_node(physics).run(&start, vec![stop - 1, stop, stop + 9]);
        assert!(seen.at(stop - 1).v[0][0] > 0.0 && seen.at(stop).v[0][0] == 0.0);
        let distance = seen.at(stop + 9).x[0][0];
        let tolerance = case.of_file("tolerance_abs");
        assert_near(distance, case.number("distance"), tolerance, &case.case);
    }
}

/// Where a node ends that is dropped from a height while it moves sideways.
fn thrown<R: Real>(case: &StabilityCase, row: &Value, contact: ContactLaw, height: R) -> R {
    let mut case_of_row = case.clone();
    case_of_row.case["dt"] = row["dt"].clone();
    let physics = on_ground(&case_of_row, contact);
    let steps = (case.number("T") / physics.dt).round() as usize;
    let start = alone([R::zero(), height], [R::lit(case.number("vx")), R::zero()]);
    Bare::free_node(physics).run_to_end(&start, steps).x[0][0]
}

#[test]
fn the_end_of_a_bounce_by_the_drop_height() {
    for case in stability_cases("exact_dx_dH_infinite") {
        let tolerance = case.of_file("tolerance_rel");
        let height = case.number("H");
        let rows = case.case["discrete"]
            .as_array()
            .expect("a row per time step");
        assert!(!rows.is_empty());
        for row in rows {
            let laws = [
                (ContactLaw::infinite(), "x_infinite", "dx_dH_infinite"),
                (
                    ContactLaw::coulomb(),
                    "x_coulomb",
                    "dx_dH_coulomb_of_discrete_map",
                ),
            ];
            for (contact, place, slope) in laws {
                let dual: Dual<f64, 1> = Dual::variable(height, 0);
                let forward = thrown(&case, row, contact.clone(), dual);
                let reverse = gradient_of(|h| thrown(&case, row, contact.clone(), h[0]), &[height]);
                for (got, key) in [
                    (forward.value, place),
                    (forward.tangent[0], slope),
                    (reverse[0], slope),
                ] {
                    assert_near(got / number(row, key), 1.0, tolerance, &key);
                }
            }
        }
    }
}
