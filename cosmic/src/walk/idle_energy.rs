//! The energy of a robot, for tests that energy is conserved.

use std::sync::Arc;

use crate::geometry::Ground;
use crate::lattice::{Body, Lattice, State};
use crate::laws::{Force, Pose};
use crate::scene::PhysicsSettings;

/// Computes the energy of a robot with idle actuators in given states.
pub struct IdleEnergy<'a> {
    lattice: &'a Lattice,
    body: &'a Body<f64>,
    forces: Vec<Arc<dyn Force>>,
    ground: Ground,
}

impl<'a> IdleEnergy<'a> {
    /// Prepares to compute the energy of a body on a lattice, with the forces of `physics`.
    pub fn new(lattice: &'a Lattice, physics: &PhysicsSettings, body: &'a Body<f64>) -> Self {
        Self {
            lattice,
            body,
            forces: physics.forces_on(lattice),
            ground: physics.into(),
        }
    }

    /// The kinetic energy plus the potential energy of all forces, J; `None` if a force has no potential energy.
    pub fn energy(&self, state: &State<f64>) -> Option<f64> {
        let speeds = state.v.iter().zip(&self.body.mass);
        let kinetic: f64 = speeds.map(|(v, m)| 0.5 * m * v.dot(*v)).sum();
        let pose = Pose::idle(self.lattice, self.body, state, &self.ground);
        let forces = self.forces.iter().map(|force| force.energy(&pose));
        Some(kinetic + forces.sum::<Option<f64>>()?)
    }
}
