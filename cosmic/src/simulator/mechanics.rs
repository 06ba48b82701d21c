//! The mechanical part of a step: forces, flight and contact, as often as a scene asks for.

use std::sync::Arc;

use autodiff::{Array, Graph, Program, Real};

use super::parameters::Parameters;
use crate::ground::Ground;
use crate::lattice::Lattice;
use crate::laws::{AnyContact, Drift, Flight, Force, Step, Terrain};
use crate::scene::{Integrator, PhysicsSettings};

/// The laws of a mechanical step of length `h = dt / substeps`.
///
/// Symplectic Euler pushes for `h` with the forces at the start, and drifts for `h`. Leapfrog
/// drifts for `h / 2`, pushes for `h` and drifts for `h / 2`, each drift with its own contact;
/// half of the damping before the push and half after it make the whole symmetric in time, and
/// of second order.
#[derive(Clone, Debug)]
pub(super) struct Mechanics {
    substeps: usize,
    /// The drift before the forces are taken, where the integrator has one.
    first: Option<Drift>,
    /// For how long the forces push, s.
    pub(super) push: f64,
    pub(super) flight: Flight,
    contact: Arc<dyn AnyContact>,
    /// The profile on the ground line; `None` on a bare line.
    terrain: Option<Terrain>,
    pub(super) forces: Vec<Arc<dyn Force>>,
    ground: Ground,
}

impl Mechanics {
    pub(super) fn new(lattice: &Lattice, physics: &PhysicsSettings) -> Self {
        let h = physics.dt / physics.substeps as f64;
        let decay = (-physics.damping * h).exp();
        // Leapfrog damps by half after a push, which takes its part of that.
        let (first, drift, push) = match physics.integrator {
            Integrator::SymplecticEuler => (None, Drift { dt: h }, h),
            Integrator::Leapfrog => {
                let half = Drift { dt: 0.5 * h };
                (Some(half), half, h * decay.sqrt())
            }
        };
        let ground = Ground::from(physics);
        Self {
            substeps: physics.substeps,
            first,
            push,
            flight: Flight {
                drift,
                decay,
                gravity: ground.vector_to_ground([0.0, -physics.gravity * push]),
            },
            contact: physics.contact_law().into(),
            terrain: Terrain::new(&physics.ground.resolved()),
            forces: physics.forces_on(lattice),
            ground,
        }
    }

    /// The same laws under another coefficient of friction.
    pub(super) fn with_friction(&self, friction: f64) -> Self {
        Self {
            contact: self.contact.with_friction(friction).into(),
            ..self.clone()
        }
    }

    /// True if a force reads the time.
    pub(super) fn needs_time(&self) -> bool {
        self.forces.iter().any(|force| force.needs_time())
    }

    /// The numbers of each force that no step changes.
    pub(super) fn constants(&self) -> impl Iterator<Item = Vec<Vec<f64>>> {
        self.forces.iter().map(|force| force.constants())
    }

    /// Records the state after the step: x, y, x velocity, y velocity of all nodes, from those
    /// before it, the activation of every slot, and the time for every node where it is needed.
    pub(super) fn record<R: Real>(
        &self,
        p: &mut Program<R>,
        graph: &Graph,
        state: [Array; 4],
        given: &Parameters<Array>,
        activation: Array,
        time: Option<Array>,
    ) -> [Array; 4] {
        let p = &mut p.any();
        let [mut x, mut y, mut vx, mut vy] = state;
        let terrain = self.terrain.as_ref();
        for _ in 0..self.substeps {
            if let Some(drift) = self.first {
                let node = [x, y, vx, vy];
                [x, y, vx, vy] = self.contact.drift(p, drift, terrain, node);
            }
            let step = Step {
                graph,
                x: [x, y],
                v: [vx, vy],
                inverse_mass: given.inverse_mass,
                activation,
                stiffness: given.stiffness,
                rest_length: given.rest_length,
                strain: given.strain,
                time,
                dt: self.push,
                ground: self.ground,
            };
            let mut impulses = None;
            for (force, constants) in self.forces.iter().zip(&given.constants) {
                impulses = Some(force.record(p, &step, constants, impulses));
            }
            let [jx, jy] = impulses.expect("springs are always there");
            let node = [x, y, vx, vy, jx, jy, given.inverse_mass];
            [x, y, vx, vy] = self.contact.fly(p, self.flight, terrain, node);
        }
        [x, y, vx, vy]
    }
}
