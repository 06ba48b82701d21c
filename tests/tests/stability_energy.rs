//! Undamped lattices over a million steps: the energy swings in a band and does not drift.

use cosmic::design::Material;
use cosmic::generator::edges;
use cosmic::geometry::{Vector, from_flat};
use cosmic::lattice::Body;
use cosmic::lattice::State;
use cosmic::laws::ContactLaw;
use cosmic::projection::one_hot;
use cosmic::scene::{MaterialSettings, PhysicsSettings};
use cosmic_tests::{Bare, StabilityCase, assert_near, number, stability_cases, stability_lists};
use serde_json::{Value, json};

/// States that are held at a time.
const CHUNK: usize = 10_000;

/// Calls `look` with the state after every step.
fn every_step(bare: &Bare, mut state: State<f64>, steps: usize, mut look: impl FnMut(&State<f64>)) {
    for first in (0..steps).step_by(CHUNK) {
        let chunk = CHUNK.min(steps - first);
        let seen = bare.run(&state, (1..=chunk).collect());
        seen.states.iter().for_each(&mut look);
        state = seen.states.last().expect("a chunk has states").clone();
    }
}

/// Kinetic energy and that of the springs, J, their length softened as the force takes it (D4).
fn energy(bare: &Bare, state: &State<f64>) -> f64 {
    let moving = bare.body.mass.iter().zip(&state.v);
    let kinetic: f64 = moving.map(|(m, v)| 0.5 * m * v.dot(*v)).sum();
    let springs = bare.lattice.edges.iter().zip(&bare.lattice.rest_length);
    let stretched = springs
        .zip(&bare.body.stiffness)
        .map(|((&[i, j], rest), k)| {
            let excess = (state.x[j] - state.x[i]).softened_norm(1e-12) - rest;
            0.5 * k * excess * excess
        });
    kinetic + stretched.sum::<f64>()
}

/// `v^2 + omega^2 x^2 - dt omega^2 x v` of one oscillator stays as it is, and its energy in the
/// band that follows from it.
#[test]
fn one_oscillator_keeps_its_invariant() {
    for case in stability_lists("linear", "invariant") {
        let (omega, dt) = (case.number("omega"), case.number("dt"));
        let mut bare = Bare::new(&[([0, 1], 1.0, 0.5 * omega * omega)], &[1.0, 1.0]);
        bare.physics.dt = dt;
        let extension = 1e-3;
        let half = 0.5 * (1.0 + extension);
        let start = State::new(vec![[-half, 0.0], [half, 0.0]], vec![[0.0; 2]; 2]);
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        let mut furthest: f64 = 0.0;
        let at_start = (omega * extension).powi(2);
        every_step(&bare, start, 1_000_000, |state| {
            let x = state.x[1][0] - state.x[0][0] - 1.0;
            let v = state.v[1][0] - state.v[0][0];
            let [kinetic, elastic] = [v * v, omega * omega * x * x];
            let invariant = kinetic + elastic - dt * omega * omega * x * v;
            furthest = furthest.max((invariant / at_start - 1.0).abs());
            (least, most) = (least.min(kinetic + elastic), most.max(kinetic + elastic));
        });
        // An extension of 1e-3 is rounded at 1e-16 in each of a million steps, at random; the
        // softening displaces the rest by 5e-13. Both are parts in 1e9 of the extension.
        assert!(furthest < 1e-8, "the invariant is off by {furthest:e}");
        let band = number(&case.case, "relative_band_max_over_min");
        assert!(
            most / least <= band * (1.0 + 1e-8),
            "{} above {band}",
            most / least
        );
        // Almost all phases come by, so that the band is filled.
        assert!(most / least > 1.0 + 0.99 * (band - 1.0));
    }
}

/// All skeleton, with the file's masses.
fn lattice(case: &StabilityCase) -> (Bare, State<f64>) {
    let [columns, rows] = ["columns", "rows"].map(|key| case.number(key) as usize);
    let lattice = case.lattice(edges(columns, rows));
    let material = &case.case["material"];
    assert_eq!(
        material, "all skeleton, m_eps 1e-4, payload 0.1",
        "no robot is known of this material: {columns}x{rows} nodes"
    );
    let physics = PhysicsSettings {
        dt: case.number("dt"),
        gravity: 0.0,
        damping: 0.0,
        node_mass: 1e-4,
        payload_mass: 0.1,
        contact: ContactLaw::none(),
        ground_height: 0.0,
        ..PhysicsSettings::default()
    };
    let mixture = one_hot(&vec![Material::Skeleton; lattice.edges.len()]);
    let body = Body::new(&mixture, &lattice, &MaterialSettings::default(), &physics);
    let x: Vec<Vector<f64>> = from_flat(&case.numbers("x0"));
    let start = State {
        v: vec![Vector::zero(); x.len()],
        x,
    };
    (
        Bare {
            lattice,
            body,
            physics,
        },
        start,
    )
}

/// A lattice of any shape has no energy while its nodes are in their places.
#[test]
fn regular_lattices_are_at_rest() {
    for (columns, rows) in [(1, 4), (2, 2), (2, 5), (3, 2), (6, 6), (5, 1)] {
        let place = |node: usize| [node % columns, node / columns].map(|n| 0.1 * n as f64);
        let case = json!({
            "columns": columns, "rows": rows, "spacing": 0.1, "dt": 0.001,
            "material": "all skeleton, m_eps 1e-4, payload 0.1",
            "x0": (0..columns * rows).map(place).collect::<Vec<_>>(),
        });
        let file = Value::Null;
        let (bare, start) = lattice(&StabilityCase { file, case });
        // The softening stretches an edge of 0.1 m by 5e-12 m, which a stiffness of 400 N/m and
        // the square make 5e-21 J.
        let held = energy(&bare, &start);
        assert!(held < 1e-18, "{columns}x{rows}: {held:e} J");
    }
}

/// Quantities watched in a rollout; energies are shares of the first.
struct Watched {
    least: f64,
    most: f64,
    /// Means over windows of equal length.
    means: Vec<f64>,
    /// The largest component of the total momentum, N s.
    momentum: f64,
}

impl Watched {
    fn new((bare, start): (Bare, State<f64>), steps: usize, windows: usize) -> Self {
        let at_start = energy(&bare, &start);
        let mut watched = Self {
            least: 1.0,
            most: 1.0,
            means: vec![0.0; windows],
            momentum: 0.0,
        };
        let window = steps / windows;
        assert!(window > 0, "{steps} steps do not fill {windows} windows");
        let mut step = 0;
        every_step(&bare, start, steps, |state| {
            let share = energy(&bare, state) / at_start;
            watched.least = watched.least.min(share);
            watched.most = watched.most.max(share);
            // Steps after the last whole window are in no mean.
            if let Some(mean) = watched.means.get_mut(step / window) {
                *mean += share / window as f64;
            }
            step += 1;
            for k in 0..2 {
                let moving = bare.body.mass.iter().zip(&state.v);
                let sum: f64 = moving.map(|(m, v)| m * v[k]).sum();
                watched.momentum = watched.momentum.max(sum.abs());
            }
        });
        watched
    }
}

#[test]
fn lattices_keep_their_energy() {
    for case in stability_cases("window_means_over_E0") {
        let (bare, start) = lattice(&case);
        let at_start = energy(&bare, &start);
        // Coordinates of 0.1 m are rounded at 1e-17, extensions are 1e-4 m and enter squared.
        let error = (at_start / case.number("E0") - 1.0).abs();
        assert!(error < 1e-12, "{at_start}");
        let expected = case.numbers("window_means_over_E0");
        let steps = case.number("steps") as usize;
        let watched = Watched::new((bare, start), steps, expected.len());
        // The file's bounds: small motions are nearly periodic, large ones chaotic, of which only
        // statistics repeat.
        let expect = &case.file["expect"];
        let small = case.number("amplitude_of_spacing") < 0.01;
        let size = if small { "small" } else { "large" };
        let spread = number(expect, &format!("window_mean_spread_{size}_amplitude"));
        for (mean, expected) in watched.means.iter().zip(&expected) {
            assert_near(*mean, *expected, spread * expected, &"mean");
        }
        for (got, key) in [
            (watched.least, "E_min_over_E0"),
            (watched.most, "E_max_over_E0"),
        ] {
            let expected = case.number(key);
            // Extremes of a million steps scatter more than means do.
            assert_near(got, expected, 2.0 * spread * expected, &key);
        }
        let most = number(expect, "momentum_abs");
        assert_near(watched.momentum, 0.0, most, &"momentum");
    }
}
