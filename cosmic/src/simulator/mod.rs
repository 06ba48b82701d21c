//! The simulator: from a body, a controller and a state to a trajectory.
//!
//! The physics stands in `kernels` and the order of a step in `robot`, each once, for every
//! number type. Internally all is in the ground's frame, where contact is a sign of one
//! coordinate; states are given and returned in the world's.

#[rustfmt::skip]
mod adjoints;
mod bending;
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

    /// The same world with another coefficient of friction; without an effect where nodes stick.
    #[must_use]
    pub fn with_friction(&self, friction: f64) -> Self {
        let mut other = self.clone();
        other.robot.friction = self.robot.friction.map(|_| friction);
        other
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
        let rollout = Rollout {
            model: self.robot.clone(),
            steps: span.observed.last().copied().unwrap_or(0),
            inputs: clock,
            observed: span.observed.clone(),
            cotangent_bound: span.cotangent_bound,
            memory: Memory::All,
        };
        let folded = Folded::new(controller, &self.controller, &self.ground);
        let rest_length: Vec<R> = self.rest_length.iter().map(|&l| R::lit(l)).collect();
        let inverse_mass: Vec<R> = body.mass.iter().map(|m| m.recip()).collect();
        let order = self.robot.edge_order();
        let row = |&edge: &usize| &folded.w2[edge * folded.hidden..][..folded.hidden];
        let w2: Vec<R> = order.iter().flat_map(row).copied().collect();
        let b2: Vec<R> = order.iter().map(|&edge| folded.b2[edge]).collect();
        let bending = self.robot.bending.as_ref();
        let bending = bending.map(|bending| bending.stiffness(&body.stiffness));
        let parameters: [&[R]; 8] = [
            &graph.to_slots(&body.stiffness),
            &rest_length,
            &graph.to_slots(&body.strain),
            &inverse_mass,
            &folded.w1,
            &folded.b1,
            &w2,
            &b2,
        ];
        let more = bending.as_deref();
        let parameters: Vec<&[R]> = parameters.into_iter().chain(more).collect();
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
