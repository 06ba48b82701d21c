//! The time step with which an oscillation begins to grow, for each integrator.
//!
//! A step of symplectic Euler maps a free oscillation of angular frequency `omega` to one that does
//! not grow exactly for `dt omega < sqrt(2 (1 + exp(-damping dt)))`; one of leapfrog for
//! `dt omega < 2 sqrt(cosh(damping dt / 2))`. With substeps `dt` is the length of one.

use crate::scene::{Integrator, PhysicsSettings};

/// Iterations after which leapfrog's limit is as good as found.
const ITERATIONS: usize = 20_000;

/// The smallest time step, s, of a scene's integrator and substeps with which an oscillation of
/// this angular frequency (1/s) grows; infinite where none does. The scene's own `dt` is not
/// looked at.
pub fn stable_step(physics: &PhysicsSettings, frequency: f64) -> f64 {
    let substep = match physics.integrator {
        Integrator::SymplecticEuler => step_limit(frequency, physics.damping),
        Integrator::Leapfrog => leapfrog_limit(frequency, physics.damping),
    };
    substep * physics.substeps as f64
}

/// [`step_limit`] of leapfrog: the smallest root of `dt omega = 2 sqrt(cosh(damping dt / 2))`. Its
/// step has the determinant `exp(-damping dt)` and the trace `1 + exp(-damping dt) -
/// exp(-damping dt / 2) (dt omega)^2`.
fn leapfrog_limit(frequency: f64, damping: f64) -> f64 {
    if frequency == 0.0 {
        return f64::INFINITY;
    }
    // From below, through numbers that are all on the safe side; without a root they grow for ever.
    let next = |dt: f64| 2.0 * (0.5 * damping * dt).cosh().sqrt() / frequency;
    let mut dt = 0.0;
    for _ in 0..ITERATIONS {
        let longer = next(dt);
        if longer <= dt || longer.is_infinite() {
            return longer;
        }
        dt = longer;
    }
    dt
}

/// The `dt omega` of symplectic Euler from which on an oscillation grows: 2 without damping,
/// towards `sqrt(2)` with much of it.
pub fn phase_limit(damping: f64, dt: f64) -> f64 {
    (2.0 * (1.0 + (-damping * dt).exp())).sqrt()
}

/// The smallest time step, s, of symplectic Euler with which an oscillation of this angular
/// frequency (1/s) grows; infinite where nothing oscillates.
pub fn step_limit(frequency: f64, damping: f64) -> f64 {
    if frequency == 0.0 {
        return f64::INFINITY;
    }
    // `dt omega` grows with dt and the limit falls: they meet once, between sqrt(2) and 2.
    let (mut below, mut above) = (1.0 / frequency, 2.0 / frequency);
    // Each halving is a binary digit.
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (below + above);
        if middle * frequency < phase_limit(damping, middle) {
            below = middle;
        } else {
            above = middle;
        }
    }
    above
}
