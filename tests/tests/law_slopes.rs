//! What every registered force says about itself agrees with what it records: its energy, and the stiffness and damping that
//! determine the stable time step.

use autodiff::{Real, jacobian};
use cosmic::geometry::Vector;
use cosmic::lattice::State;
use cosmic::settings::{SettingValue, within};
use cosmic::world::IdleEnergy;
use cosmic::world::stability::Vibration;
use cosmic_tests::{Bare, laws, robot_of};

/// Settings of forces with which they act on the robot of these tests. A force without an entry has its default settings.
const SETTINGS: [(&str, &str); 9] = [
    ("damper", "{time = 0.1}"),
    ("stops", "{at = 0.05, stiffness = 1e4}"),
    ("actuator", "{force = 0.02, speed = 1e-3}"),
    ("bumpers", "{distance = 0.6, stiffness = 1e6}"),
    (
        "bar_formula",
        "{tension = 'stiffness * (20 * (length - target) + 0.1 * rate)'}",
    ),
    (
        "node_formula",
        "{force_x = '-900 * (x + z) - 3 * vz', force_z = '-900 * x - 3 * vx'}",
    ),
    ("stiffening", "{cubic = 150}"),
    ("bending", "{radius = 0.2}"),
    ("wind", "{speed = -1}"),
];

/// The names of all forces of this crate and of the example programs.
fn forces() -> Vec<String> {
    let known = laws::scene("").physics.forces.allowed(&within(0.0, 1.0));
    let names = known.split('"').skip(1).step_by(2);
    names.map(str::to_owned).collect()
}

/// A robot with this force and springs, in a world without anything else.
fn robot(force: &str) -> Bare {
    let settings = SETTINGS.iter().find(|(name, _)| *name == force);
    let settings = settings.map_or(String::new(), |(name, text)| format!("{name} = {text}"));
    let physics = "gravity = 0.0, damping = 0.0, contact = 'none'";
    let scene = format!("physics = {{{physics}, forces = ['{force}']}}\n{settings}");
    let case = robot_of(laws::scene(&scene));
    Bare {
        body: case.body(),
        lattice: case.lattice,
        physics: case.scene.physics,
    }
}

/// Poses in which every node is away from its place at rest by up to these shares of the spacing. In the last one, some
/// nodes touch bars and some bars their stops.
const AWAY: [f64; 3] = [0.0, 0.02, 0.2];

fn pose(bare: &Bare, away: f64) -> State<f64> {
    let mut state = bare.lattice.state_at_rest();
    for (k, x) in state.x.iter_mut().enumerate() {
        let angle = 2.0 + 5.0 * k as f64;
        *x += Vector::upright(angle.sin(), angle.cos()) * (away * bare.lattice.spacing);
    }
    state
}

/// The forces on all nodes that a step records, N, as a function of positions and velocities, node by node.
fn recorded<R: Real>(bare: &Bare, x: &[R], v: &[R]) -> Vec<R> {
    let state = State::from_flat(bare.lattice.dimension, [x, v]);
    let [_, after] = bare.run_to_end(&state, 1).to_flat();
    let axes = bare.lattice.dimension.count();
    let numbers = after.into_iter().zip(v).enumerate();
    let force = |(k, (after, before)): (usize, (R, &R))| {
        (after - *before) * R::lit(bare.body.mass[k / axes] / bare.physics.dt)
    };
    numbers.map(force).collect()
}

/// The largest eigenvalue of `M^-1/2 (K + K^T) M^-1/2 / 2`, where the entries of `-K` are `slopes`; too small by rounding and
/// by what the iteration leaves.
fn largest(bare: &Bare, slopes: impl Fn(usize, usize) -> f64) -> f64 {
    let axes = bare.lattice.dimension.count();
    let root = |k: usize| bare.body.mass[k / axes].sqrt();
    let size = axes * bare.lattice.nodes();
    let entry = |i: usize, j: usize| -0.5 * (slopes(i, j) + slopes(j, i)) / (root(i) * root(j));
    let row = |i: usize| (0..size).map(|j| entry(i, j)).collect();
    let matrix: Vec<Vec<f64>> = (0..size).map(row).collect();
    // With this shift no eigenvalue is negative.
    let shift = matrix
        .iter()
        .flatten()
        .map(|entry| entry * entry)
        .sum::<f64>()
        .sqrt();
    let mut vector: Vec<f64> = (0..size).map(|k| 1.0 + 0.3 * (k as f64).sin()).collect();
    let mut value = 0.0;
    for _ in 0..3000 {
        let norm = vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        vector.iter_mut().for_each(|x| *x /= norm);
        let image = |row: &Vec<f64>| row.iter().zip(&vector).map(|(a, x)| a * x).sum::<f64>();
        let images: Vec<f64> = matrix.iter().map(image).collect();
        value = images.iter().zip(&vector).map(|(a, x)| a * x).sum();
        vector
            .iter_mut()
            .zip(images)
            .for_each(|(x, image)| *x = shift * *x + image);
    }
    value
}

/// The stable time step is not too large: no vibration of the recorded forces is faster than the stated one, and nothing
/// dampens it more.
#[test]
fn no_force_is_stiffer_than_it_says() {
    for force in forces() {
        let bare = robot(&force);
        for away in AWAY {
            let state = pose(&bare, away);
            let [x, v] = state.to_flat();
            let by_place = jacobian(|x| recorded(&bare, x, &Real::lits(&v)), &x);
            let by_velocity = jacobian(|v| recorded(&bare, &Real::lits(&x), v), &v);
            let vibration = Vibration::new(&bare.lattice, &bare.body, &bare.physics, &state.x);
            let (frequency, damping) = (vibration.fastest().0, vibration.damping());
            let square = largest(&bare, |i, j| by_place[i][j]);
            let damped = largest(&bare, |i, j| by_velocity[i][j]);
            // Rounding of the slopes and of both iterations.
            assert!(
                square <= frequency * frequency * (1.0 + 1e-9),
                "{force}, {away}: {square} {frequency}"
            );
            assert!(
                damped <= damping * (1.0 + 1e-9) + 1e-12,
                "{force}, {away}: {damped} {damping}"
            );
        }
    }
}

/// The recorded forces are the negative slopes of the energy of every force that has one.
#[test]
fn recorded_forces_are_the_slopes_of_the_energy() {
    let mut checked = Vec::new();
    for force in forces() {
        let bare = robot(&force);
        for away in AWAY {
            let state = pose(&bare, away);
            let [x, v] = state.to_flat();
            let energies = IdleEnergy::new(&bare.lattice, &bare.physics, &bare.body);
            let energy = |k: usize, by: f64| {
                let mut x = x.clone();
                x[k] += by;
                energies.energy(&State::from_flat(bare.lattice.dimension, [&x, &v]))
            };
            if energy(0, 0.0).is_none() {
                continue;
            }
            let found = recorded(&bare, &x, &v);
            let size = found
                .iter()
                .fold(0.0, |most: f64, force| most.max(force.abs()));
            for (k, found) in found.into_iter().enumerate() {
                let h = 1e-6 * bare.lattice.spacing;
                let slope = (energy(k, h).unwrap() - energy(k, -h).unwrap()) / (2.0 * h);
                let off = (found + slope).abs();
                // Differences have an error of the order of h^2. At a kink within h, such as that of a rope at its target,
                // they are off by a part of h times the stiffness, which is below 1e3 N/m there.
                assert!(
                    off < 1e-6 * size + 1e3 * h,
                    "{force}, {away}, {k}: {found} {slope}"
                );
            }
            checked.push(force.clone());
        }
    }
    checked.dedup();
    assert!(checked.len() >= 3, "{checked:?}");
}
