//! What an integrator makes of the energy of springs that nothing damps.

use crate::case::Case;
use crate::lattice::State;
use crate::projection::Body;
use crate::simulator::SOFTENING;
use crate::verify::probe::{Precise, Probe, most, narrow};

/// By how much the lattice is stretched at the start.
const STRETCH: f64 = 0.02;
/// How far the ground is lowered, m: out of reach, and not so far that heights above it lose
/// digits in f32.
const DEPTH: f64 = 1.0;

/// The energy of a stretched robot let go: no damping, no gravity, no ground, no controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// The largest departure from the energy at the start, as a share of it.
    pub ripple: f64,
    /// The mean over the last quarter of the time less that over the first, as a share of the
    /// energy at the start: zero but for a ripple where energy neither leaks nor grows.
    pub drift: f64,
}

impl Energy {
    /// Lets a case's lattice vibrate for so many steps.
    pub(super) fn of<R: Precise>(case: &Case, steps: usize) -> Self {
        let free = released(case, steps);
        let body = free.body();
        let seen = narrow(&Probe::new(&free).run::<R>(&free.start, (0..=steps).collect()));
        let energies: Vec<f64> = seen
            .states
            .iter()
            .map(|state| energy(&free, &body, state))
            .collect();
        let first = energies[0];
        let away = energies.iter().map(|e| (e / first - 1.0).abs());
        let quarter = (energies.len() / 4).max(1);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let last = mean(&energies[energies.len() - quarter..]);
        Self {
            ripple: most(away),
            drift: (last - mean(&energies[..quarter])) / first,
        }
    }
}

/// The case with its lattice stretched about its first node and let go, far above the ground.
fn released(case: &Case, steps: usize) -> Case {
    let mut case = case.clone();
    let physics = &mut case.physics;
    physics.steps = steps;
    (physics.damping, physics.gravity) = (0.0, 0.0);
    physics.ground_height -= DEPTH / physics.incline_deg.to_radians().cos();
    let origin = case.start.x[0];
    for x in &mut case.start.x {
        *x = [0, 1].map(|k| origin[k] + (1.0 + STRETCH) * (x[k] - origin[k]));
    }
    case.start.v.fill([0.0; 2]);
    let silent = &mut case.controller;
    silent.w2.fill(0.0);
    silent.b2.fill(0.0);
    case
}

/// Kinetic and elastic energy, J; lengths as the springs have them (D4).
fn energy(case: &Case, body: &Body<f64>, state: &State<f64>) -> f64 {
    let speeds = state.v.iter().zip(&body.mass);
    let kinetic: f64 = speeds
        .map(|(v, m)| 0.5 * m * (v[0] * v[0] + v[1] * v[1]))
        .sum();
    let edges = case.lattice.edges.iter().enumerate();
    let elastic = edges.map(|(e, &[i, j])| {
        let [dx, dy] = [0, 1].map(|k| state.x[j][k] - state.x[i][k]);
        let stretch = (dx * dx + dy * dy + SOFTENING).sqrt() - case.lattice.rest_length[e];
        0.5 * body.stiffness[e] * stretch * stretch
    });
    kinetic + elastic.sum::<f64>()
}
