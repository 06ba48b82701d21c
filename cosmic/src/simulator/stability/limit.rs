//! The time step with which an oscillation begins to grow, for each integrator.
//!
//! A step of symplectic Euler maps a free oscillation of angular frequency `omega` to one that does
//! not grow exactly for `dt omega < sqrt(2 (1 + exp(-damping dt)))`; one of leapfrog for
//! `dt omega < 2 sqrt(cosh(damping dt / 2))`. Forces that dampen it at a rate `eta` besides, taken at the
//! start of a step, put `(dt omega)^2 + 2 dt eta` in place of `(dt omega)^2`. With substeps `dt` is the
//! length of one.

use crate::scene::{Integrator, PhysicsSettings};

/// Iterations after which leapfrog's limit is as good as found.
const ITERATIONS: usize = 20_000;

/// The smallest time step, s, of a scene's integrator and substeps with which an oscillation of
/// this angular frequency (1/s), which forces dampen at a rate of `eta` (1/s), grows; infinite where none
/// does. The scene's own `dt` is not looked at.
pub fn stable_step(physics: &PhysicsSettings, frequency: f64, eta: f64) -> f64 {
    let substep = match physics.integrator {
        Integrator::SymplecticEuler => step_limit(frequency, physics.damping, eta),
        Integrator::Leapfrog => leapfrog_limit(frequency, physics.damping, eta),
    };
    substep * physics.substeps as f64
}

/// The time step for which `(dt omega)^2 + 2 dt eta` is the square of a number.
fn step_of(phase: f64, frequency: f64, eta: f64) -> f64 {
    let square = phase * phase;
    square / (eta + eta.hypot(phase * frequency))
}

/// [`step_limit`] of leapfrog: the smallest root of `(dt omega)^2 + 2 dt eta = 4 cosh(damping dt / 2)`. Its
/// step has the determinant `d = exp(-damping dt) - dt eta exp(-damping dt / 2)` and the trace
/// `1 + d - exp(-damping dt / 2) (dt omega)^2`.
fn leapfrog_limit(frequency: f64, damping: f64, eta: f64) -> f64 {
    if frequency == 0.0 && eta == 0.0 {
        return f64::INFINITY;
    }
    // From below, through numbers that are all on the safe side; without a root they grow for ever.
    let next = |dt: f64| step_of(2.0 * (0.5 * damping * dt).cosh().sqrt(), frequency, eta);
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
/// frequency (1/s), dampened besides at a rate of `eta` (1/s), grows; infinite where nothing oscillates.
pub fn step_limit(frequency: f64, damping: f64, eta: f64) -> f64 {
    if frequency == 0.0 && eta == 0.0 {
        return f64::INFINITY;
    }
    // What grows with dt meets the limit, which falls from 2 to sqrt(2), once.
    let [mut below, mut above] = [1.0, 2.0].map(|phase| step_of(phase, frequency, eta));
    // Each halving is a binary digit.
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (below + above);
        if middle < step_of(phase_limit(damping, middle), frequency, eta) {
            below = middle;
        } else {
            above = middle;
        }
    }
    above
}
