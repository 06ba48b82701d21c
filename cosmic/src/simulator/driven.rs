//! A simulator of robots whose activations the caller gives, in place of a controller.

use super::plan::Driving;
use super::prepare::{Simulator, Span};
use super::trajectory::Trajectory;
use crate::lattice::{Body, Lattice, State};
use crate::scene::{ControllerSettings, PhysicsSettings};

/// A simulator of robots whose activations the caller sets, as in reinforcement learning.
///
/// Robots with different activations run in parallel in SIMD lanes. No controller is evaluated.
#[derive(Clone, Debug)]
pub struct Driven(Simulator);

impl Driven {
    /// Prepares rollouts of at most `physics.steps` steps.
    pub fn new(
        lattice: &Lattice,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        Self(Simulator::new(lattice, physics, controller).driven())
    }

    /// Simulates robots that share one body, each from its own start and with its own constant activations.
    /// `activations` has one list per start, with a number from -1 to 1 for each edge.
    ///
    /// # Panics
    /// Like [`Simulator::rollout_many`], and if the number of lists or their lengths are wrong.
    pub fn held(
        &self,
        body: &Body<f64>,
        activations: &[&[f64]],
        starts: &[State<f64>],
        span: &Span,
    ) -> Vec<Trajectory<f64>> {
        let (world, bodies) = (&self.0, std::slice::from_ref(body));
        let starts: Vec<&State<f64>> = starts.iter().collect();
        world.check(bodies, &starts);
        world.fits("lists of activations", activations.len(), starts.len());
        for held in activations {
            world.fits("activations", held.len(), body.strain.len());
        }
        let model = world.robot.for_bodies(bodies);
        let slots = activations.iter().map(|held| model.graph.to_slots(held));
        let surroundings = [world.surroundings()];
        let driving = Driving::Held(slots.collect());
        let numbers = world.numbers(&model, &surroundings, bodies, driving);
        world.in_lanes(model, &surroundings, bodies, &numbers, &starts, span)
    }
}
