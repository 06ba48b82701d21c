//! Checks of lattices over many steps: the stable time step, the energy, and the way in which they come to rest.

use super::StabilityCase;
use cosmic::design::{Design, Material};
use cosmic::geometry::{Ground, Vector};
use cosmic::lattice::{Body, Lattice, State};
use cosmic::laws::ContactLaw;
use cosmic::scene::{MaterialSettings, PhysicsSettings, edges, stable_step};
use cosmic::walk::IdleEnergy;
use cosmic::world::Trajectory;
use cosmic::world::stability::Vibration;
use cosmic_tests::{Bare, assert_near, number};

pub(super) fn has_stable_steps(case: &StabilityCase) {
    let (lattice, physics) = (case.lattice(case.edges()), case.world());
    let body = case.body(&lattice);
    let vibration = Vibration::new(&lattice, &body, &physics, &case.points("positions"));
    let [fastest, bound] = [vibration.fastest().0, vibration.edge_bound().0];
    case.relative("omega_bound_edge", bound);
    case.relative("omega_max", fastest);
    let limit = |frequency| stable_step(&physics, frequency, 0.0);
    case.relative("dt_limit_exact", limit(fastest));
    case.relative("dt_limit_from_bound", limit(bound));
}

/// Simulates a robot and calls `look` with the state after every step.
pub(super) fn every_step(
    bare: &Bare,
    mut state: State<f64>,
    steps: usize,
    mut look: impl FnMut(&State<f64>),
) {
    /// The number of states that are kept in memory at a time.
    const CHUNK: usize = 10_000;
    for first in (0..steps).step_by(CHUNK) {
        let chunk = CHUNK.min(steps - first);
        let seen = bare.run(&state, (1..=chunk).collect());
        seen.states.iter().for_each(&mut look);
        state = seen.states.last().expect("a chunk has states").clone();
    }
}

/// Checks the energy of a lattice without damping in which every edge is skeleton. The energy must oscillate within a
/// band and must not drift.
pub(super) fn keeps_its_energy(case: &StabilityCase) {
    let [columns, rows] = ["columns", "rows"].map(|key| case.number(key) as usize);
    let material = &case.case["material"];
    assert_eq!(
        material, "all skeleton, m_eps 1e-4, payload 0.1",
        "unknown material"
    );
    let lattice = case.lattice(edges(columns, rows));
    let physics = PhysicsSettings {
        node_mass: 1e-4,
        payload_mass: 0.1,
        ..case.world()
    };
    let design = Design::Layout(vec![Material::Skeleton; lattice.edges.len()]);
    let body = Body::new(&design, &lattice, &MaterialSettings::default(), &physics);
    let x = case.points("x0");
    let v = vec![Vector::zero(); x.len()];
    let start = State::new(x, v);
    let bare = Bare {
        lattice,
        body,
        physics,
    };
    let store = IdleEnergy::new(&bare.lattice, &bare.physics, &bare.body);
    let energy = |state: &State<f64>| store.energy(state).expect("springs have an energy");
    let at_start = energy(&start);
    // Coordinates of 0.1 m are rounded at 1e-17. The energy depends on the squares of extensions, which are 1e-4 m.
    case.near("E0", at_start, 1e-12 * at_start);

    // Energies are divided by the first energy, and averaged over windows of equal length.
    let expected = case.numbers("window_means_over_E0");
    let steps = case.number("steps") as usize;
    let window = steps / expected.len();
    let mut means = vec![0.0; expected.len()];
    let (mut least, mut most, mut momentum, mut step) = (1.0f64, 1.0f64, 0.0f64, 0);
    every_step(&bare, start, steps, |state| {
        let share = energy(state) / at_start;
        (least, most) = (least.min(share), most.max(share));
        // Steps after the last complete window are not part of a mean.
        if let Some(mean) = means.get_mut(step / window) {
            *mean += share / window as f64;
        }
        step += 1;
        for k in 0..2 {
            let moving = bare.body.mass.iter().zip(&state.v);
            let sum: f64 = moving.map(|(m, v)| m * v.in_plane()[k]).sum();
            momentum = momentum.max(sum.abs());
        }
    });
    // The bounds are in the file. Small motions are nearly periodic. Large motions are chaotic, so that only their
    // statistics can be compared.
    let expect = &case.file["expect"];
    let small = case.number("amplitude_of_spacing") < 0.01;
    let size = if small { "small" } else { "large" };
    let spread = number(expect, &format!("window_mean_spread_{size}_amplitude"));
    for (mean, expected) in means.iter().zip(&expected) {
        assert_near(*mean, *expected, spread * expected, &"mean");
    }
    for (got, key) in [(least, "E_min_over_E0"), (most, "E_max_over_E0")] {
        // The extreme values over a million steps vary more than the means.
        case.near(key, got, 2.0 * spread * case.number(key));
    }
    assert_near(momentum, 0.0, number(expect, "momentum_abs"), &"momentum");
}

/// Checks that a dropped lattice comes to rest on the ground within a hundred thousand steps. It has one material per
/// edge and idle actuators. If friction is too weak to hold it, checks how it slides.
pub(super) fn comes_to_rest(case: &StabilityCase) {
    let physics = case.world();
    let lattice = Lattice {
        scale: 1.0,
        ..Lattice::between(case.points("x0"), case.edges())
    };
    let mut body = case.body(&lattice);
    body.strain.fill(0.0);
    let start = lattice.state_at_rest();
    let bare = Bare {
        lattice,
        body,
        physics,
    };
    // Observe every step until the lattice has landed, and then every hundredth step.
    let observed = (0..20_000).chain((20_000..=100_000).step_by(100));
    let seen = bare.run(&start, observed.collect());
    let physics = &bare.physics;
    // True if friction holds the lattice, so that it comes to rest.
    let slope = physics.incline_deg.to_radians().tan();
    let rests = physics.contact == ContactLaw::infinite() || physics.friction > slope;
    for step in [20_000, 100_000] {
        let expected = case.points(&format!("x_{step}"));
        let path = largest_difference(&expected, &start.x);
        let bound = match rests {
            true => case.of_file("tolerance_abs_resting"),
            false => 1e-6 * path,
        };
        let error = largest_difference(&seen.at(step).x, &expected);
        assert_near(error, 0.0, bound, &step);
    }
    let ground = Ground::from(physics);
    if rests {
        let moved = largest_difference(&seen.at(20_000).x, &seen.at(100_000).x);
        // After 20 000 steps, all motion has decayed, and rounding errors of 1e-17 do not add up. The bound would
        // reveal a creep of a micrometre in hours.
        assert!(moved < 1e-8, "it creeps: {moved:e}");
        stands_still(seen.at(100_000), &ground);
    }
    sinks_nowhere(&seen, &ground);
}

fn largest_difference(a: &[Vector<f64>], b: &[Vector<f64>]) -> f64 {
    let pairs = a
        .iter()
        .flat_map(|x| x.array())
        .zip(b.iter().flat_map(|x| x.array()));
    pairs.fold(0.0, |largest, (a, b)| largest.max((a - b).abs()))
}

/// Asserts that nodes on the ground stand still and that other nodes almost stand still. The file states the bounds.
fn stands_still(state: &State<f64>, ground: &Ground) {
    let mut contacts = 0;
    for (x, v) in state.to_ground(ground).x.iter().zip(&state.v) {
        let speed = v.norm();
        // The height of a node on the ground is zero except for rounding.
        if x.up() < 1e-12 {
            contacts += 1;
            assert_eq!(speed, 0.0);
        }
        assert!(speed < 1e-11, "{speed:e}");
    }
    assert!(contacts > 0, "nothing is on the ground");
}

fn sinks_nowhere(seen: &Trajectory<f64>, ground: &Ground) {
    for (state, step) in seen.states.iter().zip(&seen.steps) {
        let coordinates = state.x.iter().flat_map(|x| x.array());
        let size = coordinates.fold(1.0, |m: f64, x| m.max(x.abs()));
        let points = state.to_ground(ground).x;
        let lowest = points.iter().map(|x| x.up()).fold(f64::INFINITY, f64::min);
        // The bound of the file, plus the rounding error of coordinates of a hundred metres in a rotation.
        assert!(lowest >= -1e-12 * size, "step {step}: {lowest:e}");
    }
}
