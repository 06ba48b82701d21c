//! Whether the walk of a robot depends on how time is cut into steps: the same rollouts with half the time step, and with
//! another integrator.

use serde::{Deserialize, Serialize};

use super::evaluator::Evaluator;
use crate::design::{Design, Mixture};
use crate::policy::Controller;
use crate::scene::{Integrator, PhysicsSettings, STABLE_SHARE};
use crate::world::Variation;

/// The largest number of substeps with which another integrator is tried. Bars that need more make it too slow, and a
/// scene that solves them implicitly has reasons to do so.
const MOST_SUBSTEPS: f64 = 64.0;

/// Medians over eight of the starts of [`Delivery::spread`](super::Delivery::spread) with other time steps. Minus infinity if too
/// many rollouts diverge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Medians {
    /// Displacement along the ground, m.
    pub displacement: f64,
    /// The number by which robots are ranked, in the unit of [`Delivery::selection`](super::Delivery::selection).
    pub merit: f64,
}

/// The same robot, simulated in other ways.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OtherSteps {
    /// With half the time step: the controller acts twice as often.
    pub half: Medians,
    /// With another integrator at the scene's time step; `None` if it would need more than 64 substeps. Explicit scenes
    /// are compared with the other explicit step, implicit ones with symplectic Euler.
    pub integrator: Option<(Integrator, Medians)>,
}

impl OtherSteps {
    /// The lowest of the median merits.
    pub(super) fn least_merit(&self) -> f64 {
        let other = self
            .integrator
            .map_or(f64::INFINITY, |(_, medians)| medians.merit);
        self.half.merit.min(other)
    }
}

impl Evaluator {
    /// Simulates a robot from the starts of `variations` with half the time step and with another integrator.
    pub(super) fn with_other_steps(
        &self,
        design: &Design<Mixture<f64>>,
        controller: &Controller<f64>,
        variations: &[Variation],
    ) -> OtherSteps {
        let medians = |physics: &PhysicsSettings| {
            let world = self.world.with_physics(physics, &self.scene.controller);
            let other = self.in_world(world);
            let spread = other.spreads(design, &[controller], variations).remove(0);
            Medians {
                displacement: spread.displacement.p50,
                merit: spread.merit.p50,
            }
        };
        let other = self.other_integrator(design);
        OtherSteps {
            half: medians(&self.half_step()),
            integrator: other.map(|other| (other.integrator, medians(&other))),
        }
    }

    /// The physics of the scene with half the time step: the controller acts twice as often.
    pub(super) fn half_step(&self) -> PhysicsSettings {
        let own = &self.scene.physics;
        PhysicsSettings {
            dt: 0.5 * own.dt,
            steps: 2 * own.steps,
            ..own.clone()
        }
    }

    /// The physics of the scene with another integrator, and as many substeps as that integrator needs for this design.
    fn other_integrator(&self, design: &Design<Mixture<f64>>) -> Option<PhysicsSettings> {
        let own = &self.scene.physics;
        let (integrator, substeps) = match own.integrator {
            Integrator::SymplecticEuler => (Integrator::Leapfrog, own.substeps),
            Integrator::Leapfrog => (Integrator::SymplecticEuler, own.substeps),
            Integrator::Implicit => (Integrator::SymplecticEuler, 1),
        };
        let other = PhysicsSettings {
            integrator,
            substeps,
            ..own.clone()
        };
        let world = self.world.with_physics(&other, &self.scene.controller);
        // The 0 claims that no step is stable for every design, so the limit of this design is computed.
        let check = world.step_check(design, &self.start.x, 1.0, 0.0);
        let limit = check.exact.unwrap_or(check.bound);
        let needed = substeps as f64 * (limit.share(own.dt) / STABLE_SHARE).max(1.0);
        let needed = needed.ceil();
        (needed <= MOST_SUBSTEPS.max(substeps as f64)).then(|| PhysicsSettings {
            substeps: needed as usize,
            ..other
        })
    }
}
