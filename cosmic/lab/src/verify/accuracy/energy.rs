//! The energy of undamped springs under an integrator.

use crate::verify::probe::{Probe, energies, most};
use autodiff::Real;
use cosmic::case::Case;
use cosmic::laws::ForceLaws;

/// The stretch of the lattice at the start.
const STRETCH: f64 = 0.02;
/// How far the ground is lowered, m: out of reach, and not so far that heights above it lose
/// digits in f32.
const DEPTH: f64 = 1.0;

/// The energy of a stretched robot that is let go, without damping, gravity, ground, controller or forces
/// other than springs and bending.
#[derive(Clone, Copy, Debug)]
pub(super) struct Energy {
    /// The largest departure from the energy at the start, as a share of it.
    pub(super) ripple: f64,
    /// The mean over the last quarter of the time less the mean over the first quarter, as a share of
    /// the energy at the start. Energy that neither leaks nor grows leaves only a ripple.
    pub(super) drift: f64,
}

impl Energy {
    /// Lets a case's lattice vibrate for so many steps.
    pub(super) fn of<R: Real + Into<f64>>(case: &Case, steps: usize) -> Self {
        let free = released(case, steps);
        let seen = Probe::new(&free).run::<R>((0..=steps).collect());
        let energies = energies(&free, &seen.states).expect("springs and bending have an energy");
        let first = energies[0];
        let quarter = (energies.len() / 4).max(1);
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let last = mean(&energies[energies.len() - quarter..]);
        Self {
            ripple: most(energies.iter().map(|e| (e / first - 1.0).abs())),
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
    physics.forces = ForceLaws::default();
    physics.ground_height -= DEPTH / physics.incline_deg.to_radians().cos();
    let origin = case.start.x[0];
    for x in &mut case.start.x {
        *x = [0, 1].map(|k| origin[k] + (1.0 + STRETCH) * (x[k] - origin[k]));
    }
    case.start.v.fill([0.0; 2]);
    case.controller.numbers_mut().fill(0.0);
    case
}

#[cfg(test)]
mod tests {
    use super::Energy;
    use crate::verify::probe::small;
    use cosmic::scene::{Integrator, Scene};

    /// Leapfrog keeps an energy that departs from the true one by the square of the time step, unless
    /// that energy leaves out a spring or a bar.
    #[test]
    fn every_kind_of_spring_is_counted() {
        for (bending_radius, stiffening) in [(0.0, 0.0), (0.02, 0.0), (0.0, 1e4), (0.02, 1e4)] {
            let ripple = |refined: usize| {
                let case = small([3, 3], |Scene { physics, .. }| {
                    (physics.bending_radius, physics.stiffening) = (bending_radius, stiffening);
                    physics.integrator = Integrator::Leapfrog;
                    physics.dt = 1e-3 / refined as f64;
                });
                Energy::of::<f64>(&case, 200 * refined).ripple
            };
            let ratio = ripple(1) / ripple(4);
            // Sixteen, except for terms of higher order and for maxima between the steps.
            assert!(
                (13.0..20.0).contains(&ratio),
                "{bending_radius} m, {stiffening}: {ratio}"
            );
        }
    }
}
