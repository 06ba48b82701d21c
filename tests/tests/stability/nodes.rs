//! Checks of single nodes: flight, contact at the beginning or the end of a step, friction on an incline, and the
//! derivative of a bounce with respect to the drop height.

use super::StabilityCase;
use autodiff::{Dual, Real, gradient};
use cosmic::geometry::{Ground, Vector};
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::scene::PhysicsSettings;
use cosmic_tests::{Bare, assert_near, number};

/// A state of [`Bare::free_node`]: both nodes have the position `x` and the velocity `v`.
fn alone<R: Real>(x: [R; 2], v: [R; 2]) -> State<R> {
    State::new([x; 2], [v; 2])
}

/// The number of steps in which damping reduces a velocity by the factor exp(-40) = 4e-18.
fn forty_decays(physics: &PhysicsSettings) -> usize {
    (40.0 / (physics.damping * physics.dt)).ceil() as usize
}

pub(super) fn flies(case: &StabilityCase) {
    let physics = case.world();
    let bare = Bare::free_node(physics.clone());
    let start = [case.number("vx"), case.number("vy")];
    let start = alone([0.0, case.number("y0")], start);
    let end = bare.run_to_end(&start, case.number("steps") as usize);
    let tolerance = case.of_file("tolerance_rel");
    let ([x, v], expected) = ([end.x[0], end.v[0]].map(Vector::in_plane), case.vector("v"));
    let at = [case.number("x"), case.number("y")];
    for (got, expected) in x.into_iter().chain(v).zip(at.into_iter().chain(expected)) {
        // A velocity that has almost decayed is compared with a bound relative to its original size.
        let bound = tolerance * expected.abs().max(1e-3);
        assert_near(got, expected, bound, &case.case);
    }
    // The distance from the exact parabola is of first order in dt, and the file has its value. The tolerance is for
    // the rounding errors of numbers that are as large as the length of the flight.
    let (continuous, error) = (case.numbers("continuous"), case.numbers("error"));
    let size = continuous
        .iter()
        .fold(x[1].abs(), |most, c| most.max(c.abs()));
    for k in 0..2 {
        assert_near(x[k] - continuous[k], error[k], tolerance * size, &case.case);
    }
    if physics.damping > 0.0 {
        let steps = forty_decays(&physics);
        let end = bare.run_to_end(&alone([0.0; 2], [0.0; 2]), steps);
        case.relative("terminal_velocity_discrete", end.v[0].up());
    }
}

pub(super) fn lands(case: &StabilityCase) {
    let physics = case.world();
    let steps = case.number("steps") as usize;
    let (frame, x) = (case.frame(), case.vector("x0").into());
    let start = alone(frame.read(x).in_plane(), case.vector("v0"));
    let seen = Bare::free_node(physics.clone()).run(&start, (0..=steps).collect());
    let tolerance = case.of_file("tolerance_abs");
    let rows = case.numbers("states_step_x_y_vx_vy");
    for [step, expected @ ..] in rows.as_chunks::<5>().0 {
        let state = seen.at(*step as usize);
        let got = [frame.written(state.x[0]), state.v[0]].map(Vector::in_plane);
        let got = got.into_iter().flatten();
        for (got, expected) in got.zip(expected) {
            assert_near(got, *expected, tolerance, &case.case);
        }
    }
    let ground = Ground::from(&physics);
    let gravity: Vector<f64> = [0.0, -physics.gravity].into();
    let pull = ground.vector_to_ground(gravity).up();
    let decay = (-physics.damping * physics.dt).exp();
    // Returns the number of a step, counted from 1, and the time of impact in this step; `None` if the node does not
    // touch the ground in it. Until the impact, the node moves towards the ground at constant speed; then it loses this
    // speed.
    let time_of_impact = |step: usize| {
        let [before, after] = [step - 1, step].map(|s| seen.at(s).to_ground(&ground));
        let towards = decay * before.v[0].up() + pull * physics.dt;
        // Speeds are of order one, and the rotation of the incline rounds them.
        let touches = towards < -1e-14 && after.v[0].up().abs() < 1e-14;
        touches.then(|| (step, (after.x[0].up() - before.x[0].up()) / towards))
    };
    let touches: Vec<(usize, f64)> = (1..=steps).filter_map(time_of_impact).collect();
    let listed = case.numbers("first_touches_step_tau");
    for ([step, time], (got_step, got_time)) in listed.as_chunks::<2>().0.iter().zip(&touches) {
        assert_eq!(*got_step, *step as usize, "{}", case.case);
        // Heights are rounded at 1e-16, and the node falls at 0.02 m/s or more, so the time of impact is exact to about
        // 1e-14 s.
        assert_near(*got_time, *time, 1e-13, &case.case);
    }
    assert!(touches.len() >= listed.len() / 2, "{}", case.case);
    // If the node stops at the beginning of the first step, the bits of its position do not change.
    let stops_at_once = listed[..2] == [1.0, 0.0] && physics.contact == ContactLaw::infinite();
    if stops_at_once && physics.incline_deg == 0.0 {
        let stays = |state: &State<f64>| state.x[0] == start.x[0];
        assert!(seen.states.iter().all(stays), "{}", case.case);
    }
}

/// The physics of a case, with ground and this contact law.
fn on_ground(case: &StabilityCase, contact: ContactLaw) -> PhysicsSettings {
    PhysicsSettings {
        contact,
        ..case.world()
    }
}

/// Checks that a node on an incline slides if and only if the slope is larger than the coefficient of friction.
pub(super) fn slides(case: &StabilityCase) {
    let physics = on_ground(case, ContactLaw::coulomb());
    let ground = Ground::from(&physics);
    let run = |steps| {
        let bare = Bare::free_node(physics.clone());
        let end = bare.run_to_end(&alone([0.0; 2], [0.0; 2]), steps);
        let end = end.to_ground(&ground);
        [-end.x[0].forward(), -end.v[0].forward()]
    };
    let [slid, speed] = run(case.number("steps") as usize);
    case.absolute("slid_down", slid);
    case.absolute("speed", speed);
    assert_eq!(case.case["slides"], slid != 0.0);
    if case.case["terminal_speed"].is_number() {
        case.absolute("terminal_speed", run(forty_decays(&physics))[1]);
    }
}

pub(super) fn brakes(case: &StabilityCase) {
    let physics = on_ground(case, ContactLaw::coulomb());
    let start = alone([0.0; 2], [case.number("v0"), 0.0]);
    let stop = case.number("stops_at_step") as usize;
    let seen = Bare::free_node(physics).run(&start, vec![stop - 1, stop, stop + 9]);
    assert!(seen.at(stop - 1).v[0].forward() > 0.0 && seen.at(stop).v[0].forward() == 0.0);
    case.absolute("distance", seen.at(stop + 9).x[0].forward());
}

/// Checks the bounce of a node that also moves sideways: its last state, and the derivative of that state with respect
/// to the drop height.
pub(super) fn bounces(case: &StabilityCase) {
    fn end<R: Real>(case: &StabilityCase, contact: ContactLaw, height: R) -> R {
        let physics = on_ground(case, contact);
        let steps = (case.number("T") / physics.dt).round() as usize;
        let start = alone([R::zero(), height], [R::lit(case.number("vx")), R::zero()]);
        Bare::free_node(physics).run_to_end(&start, steps).x[0].forward()
    }
    let tolerance = case.of_file("tolerance_rel");
    let height = case.number("H");
    let rows = case.case["discrete"]
        .as_array()
        .expect("a row per time step");
    assert!(!rows.is_empty());
    for row in rows {
        let mut of_row = case.clone();
        of_row.case["dt"] = row["dt"].clone();
        let slope_of_coulomb = "dx_dH_coulomb_of_discrete_map";
        for (contact, place, slope) in [
            (ContactLaw::infinite(), "x_infinite", "dx_dH_infinite"),
            (ContactLaw::coulomb(), "x_coulomb", slope_of_coulomb),
        ] {
            let dual: Dual<f64, 1> = Dual::variable(height, 0);
            let forward = end(&of_row, contact.clone(), dual);
            let reverse = gradient(|h| end(&of_row, contact.clone(), h[0]), &[height]);
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
