//! The simulator: from a body, a controller and a state to a trajectory.
//!
//! The physics stands in `kernels` and the order of a step in `robot`, each once, for every
//! number type. Internally all is in the ground's frame, where contact is a sign of one
//! coordinate; states are given and returned in the world's.

#[rustfmt::skip]
mod adjoints;
mod divergence;
#[cfg(test)]
mod emission;
mod kernels;
mod robot;
pub mod stability;
mod trajectory;

use std::sync::Arc;

use autodiff::{CotangentBound, Memory, Real, Rollout};

pub use divergence::Divergence;
pub use trajectory::Trajectory;

use crate::controller::{Controller, Folded, clock};
use crate::lattice::{Ground, Lattice, State};
use crate::projection::Body;
use crate::scene::{ControllerSettings, PhysicsSettings};
use robot::Robot;

/// Which steps are done, and what is looked at.
#[derive(Clone, Debug)]
pub struct Span {
    /// The number of steps that were done before the start's state: the clock's time is
    /// `(first + n) dt`.
    pub first: usize,
    /// Numbers of steps done from the start on at which the state is wanted, ascending; the last
    /// ends the rollout.
    pub observed: Vec<usize>,
    /// Holds the cotangent back in the reverse sweep; `None` gives the exact gradient.
    pub cotangent_bound: Option<CotangentBound>,
}

impl Span {
    /// From the start on, with exact gradients.
    pub fn from_start(observed: Vec<usize>) -> Self {
        Self {
            first: 0,
            observed,
            cotangent_bound: None,
        }
    }
}

/// A lattice in its surroundings, ready to run bodies and controllers.
#[derive(Clone, Debug)]
pub struct Simulator {
    robot: Robot,
    ground: Ground,
    controller: ControllerSettings,
    /// Rest lengths in the slots of the robot's graph.
    rest_length: Vec<f64>,
    /// Sine and cosine of the clock's phase, step by step.
    clock: Arc<[f64]>,
}

impl Simulator {
    /// Plans rollouts of at most `physics.steps` steps.
    pub fn new(
        lattice: &Lattice,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        let robot = Robot::new(lattice, physics, controller);
        // A product, not a sum: the phase reaches 164 rad.
        let time = |step: usize| step as f64 * physics.dt;
        let clock = (0..physics.steps)
            .flat_map(|step| clock(controller, time(step)))
            .collect();
        Self {
            rest_length: robot.graph.to_slots(&lattice.rest_length),
            robot,
            ground: Ground::from(physics),
            controller: controller.clone(),
            clock,
        }
    }

    /// Steps a robot from a state in the world's frame.
    ///
    /// # Panics
    /// If body, controller or state are of another lattice, or the span goes past the planned
    /// steps.
    pub fn rollout<R: Real>(
        &self,
        (body, controller): (&Body<R>, &Controller<R>),
        start: &State<R>,
        span: &Span,
    ) -> Trajectory<R> {
        let graph = &self.robot.graph;
        // The whole clock is shared; a later part of it is copied.
        let clock = match span.first {
            0 => Arc::clone(&self.clock),
            first => self.clock[2 * first..].into(),
        };
        let strain = graph.to_slots(&body.strain);
        let robot = self.robot.for_strain(&strain);
        let rollout = Rollout {
            model: robot.clone(),
            steps: span.observed.last().copied().unwrap_or(0),
            inputs: clock,
            observed: span.observed.clone(),
            cotangent_bound: span.cotangent_bound,
            memory: Memory::All,
        };
        let network = self.network(&robot, controller);
        let rest_length: Vec<R> = self.rest_length.iter().map(|&l| R::lit(l)).collect();
        let inverse_mass: Vec<R> = body.mass.iter().map(|m| m.recip()).collect();
        let stiffness = graph.to_slots(&body.stiffness);
        let mut parameters: Vec<&[R]> = vec![&stiffness, &rest_length, &strain, &inverse_mass];
        parameters.extend(network.iter().map(Vec::as_slice));
        let seen = rollout.run(&self.flatten(start), &parameters);
        let states = seen
            .chunks_exact(4 * graph.nodes())
            .map(|s| self.unflatten(s))
            .collect();
        Trajectory {
            steps: span.observed.clone(),
            states,
        }
    }

    /// The folded controller as the robot's parameters: what it senses, and what has an effect.
    fn network<R: Real>(&self, robot: &Robot, controller: &Controller<R>) -> Vec<Vec<R>> {
        let actuators = robot.actuators();
        if actuators.is_empty() {
            return Vec::new();
        }
        let folded = Folded::new(controller, &self.controller, &self.ground);
        let columns = robot.sensed_columns();
        let seen = folded.w1.iter().zip(columns.iter().cycle());
        let w1 = seen.filter(|(_, seen)| **seen).map(|(&w, _)| w).collect();
        let row = |&edge: &usize| &folded.w2[edge * folded.hidden..][..folded.hidden];
        let w2 = actuators.iter().flat_map(row).copied().collect();
        let b2 = actuators.iter().map(|&edge| folded.b2[edge]).collect();
        vec![w1, folded.b1, w2, b2]
    }

    /// A state of the world's frame as the robot's arrays.
    fn flatten<R: Real>(&self, state: &State<R>) -> Vec<R> {
        let State { x, v } = state.to_ground(&self.ground);
        let column = |points: &[[R; 2]], k: usize| points.iter().map(|p| p[k]).collect::<Vec<R>>();
        [column(&x, 0), column(&x, 1), column(&v, 0), column(&v, 1)].concat()
    }

    fn unflatten<R: Real>(&self, state: &[R]) -> State<R> {
        let nodes = self.robot.graph.nodes();
        let points = |from: usize| (from..from + nodes).map(|i| [state[i], state[i + nodes]]);
        State {
            x: points(0).collect(),
            v: points(2 * nodes).collect(),
        }
        .to_world(&self.ground)
    }
}
