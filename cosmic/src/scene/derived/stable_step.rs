//! The time step at which an oscillation begins to grow, for each integrator.
//!
//! A free oscillation of angular frequency `omega` stays bounded with symplectic Euler if and only if `dt omega <
//! sqrt(2 (1 + exp(-damping dt)))`, and with leapfrog if and only if `dt omega < 2 sqrt(cosh(damping dt / 2))`. If the
//! forces of a step also dampen the oscillation at a rate `eta`, `(dt omega)^2 + 2 dt eta` takes the place of `(dt
//! omega)^2`. With substeps, `dt` is the length of a substep.
//!
//! An implicit step has no such limit. Its limit is that of rounding: if `(dt omega)^2`, the stiffness of a step divided by
//! a mass, is above 1e13, the mass is lost in the rounding of the stiffness. Forces that do not act along bars are not
//! solved for, so they have a limit of their own. With one pass, it is the limit of symplectic Euler without damping. Each
//! further pass evaluates these forces where the pass before has moved the nodes, which doubles the stiffness that they
//! seem to have: the limit is `(dt omega)^2 + dt eta < 1`.

use crate::scene::sections::{Integrator, PhysicsSettings};

/// The largest share of the stable step that a mechanical step takes. The stable step is that of vibrations about the
/// state at rest; stretched and compressed bars vibrate a little faster.
pub(crate) const STABLE_SHARE: f64 = 0.97;

/// The largest number of iterations for the limit of leapfrog. Far fewer are almost always enough.
const ITERATIONS: usize = 20_000;

/// The `dt omega` above which rounding spoils an implicit step.
const IMPLICIT: f64 = 3e6;

/// The smallest time step, s, with which an oscillation of angular frequency `frequency` (1/s) grows, for the
/// integrator and the substeps of `physics`. Infinite if it never grows. `eta` is the rate (1/s) at which forces dampen
/// the oscillation. `physics.dt` is ignored.
pub fn stable_step(physics: &PhysicsSettings, frequency: f64, eta: f64) -> f64 {
    let substep = match physics.integrator {
        Integrator::SymplecticEuler => euler_limit(frequency, physics.damping, eta),
        Integrator::Leapfrog => leapfrog_limit(frequency, physics.damping, eta),
        Integrator::Implicit => IMPLICIT / frequency,
    };
    substep * physics.substeps as f64
}

/// The smallest time step, s, with which forces that do not act along bars make an oscillation grow in an implicit step;
/// infinite with the other integrators, whose [`stable_step`] includes these forces. `frequency` and `eta` (1/s) are those
/// that these forces cause.
pub(crate) fn stable_step_off_bars(physics: &PhysicsSettings, frequency: f64, eta: f64) -> f64 {
    let substep = match (physics.integrator, physics.passes) {
        (Integrator::Implicit, 1) => step_of(2.0, frequency, eta),
        (Integrator::Implicit, _) => step_of(1.0, frequency, 0.5 * eta),
        _ => f64::INFINITY,
    };
    substep * physics.substeps as f64
}

/// The time step `dt` at which `(dt omega)^2 + 2 dt eta` equals the square of `phase`.
fn step_of(phase: f64, frequency: f64, eta: f64) -> f64 {
    let square = phase * phase;
    square / (eta + eta.hypot(phase * frequency))
}

/// Like [`euler_limit`], for leapfrog: the smallest root of `(dt omega)^2 + 2 dt eta = 4 cosh(damping dt / 2)`. The
/// matrix of a leapfrog step has the determinant `d = exp(-damping dt) - dt eta exp(-damping dt / 2)` and the trace
/// `1 + d - exp(-damping dt / 2) (dt omega)^2`.
fn leapfrog_limit(frequency: f64, damping: f64, eta: f64) -> f64 {
    if frequency == 0.0 && eta == 0.0 {
        return f64::INFINITY;
    }
    // The iteration approaches the root from below, through stable time steps. Without a root it grows without limit.
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

/// The `dt omega` at which an oscillation begins to grow with symplectic Euler: 2 without damping, and down to
/// `sqrt(2)` with strong damping.
pub fn phase_limit(damping: f64, dt: f64) -> f64 {
    (2.0 * (1.0 + (-damping * dt).exp())).sqrt()
}

/// The smallest time step, s, with which an oscillation of this angular frequency (1/s) grows with symplectic Euler.
/// `eta` is the rate (1/s) at which forces dampen it. The result is infinite if nothing oscillates.
fn euler_limit(frequency: f64, damping: f64, eta: f64) -> f64 {
    if frequency == 0.0 && eta == 0.0 {
        return f64::INFINITY;
    }
    // As dt grows, the phase grows and its limit falls from 2 to sqrt(2), so they are equal at exactly one dt.
    let [mut below, mut above] = [1.0, 2.0].map(|phase| step_of(phase, frequency, eta));
    // Each halving of the interval determines one more binary digit.
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
