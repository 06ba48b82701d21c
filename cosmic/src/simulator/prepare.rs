//! [`Simulator`]: a lattice with the physics of a scene, prepared for rollouts. [`Span`]: how long a rollout is.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use autodiff::Real;
use autodiff_programs::{CotangentBound, Memory};

use super::robot::{Drive, Robot};
use super::surroundings::Surroundings;
use crate::geometry::Ground;
use crate::lattice::{Body, Lattice, State};
use crate::policy::{Controller, Goals};
use crate::scene::{ControllerSettings, PhysicsSettings};

/// The steps of a rollout, and the states that are observed.
#[derive(Clone, Debug)]
pub struct Span {
    /// The number of steps on the clock at the start: after `n` steps of the span, the time is `(first + n) dt`.
    pub first: usize,
    /// The numbers of steps after which the state is observed, ascending. The rollout ends at the last one.
    pub observed: Vec<usize>,
    /// The number of nodes in an observed state, at least one: it contains only the first `nodes` nodes.
    pub nodes: usize,
    /// If true, every state after the start is checked in a cheap way for absurd positions and too fast nodes. If a
    /// state fails this check, all observations become NaN. [`Simulator::guarded`] relies on this.
    pub watched: bool,
    /// A bound on the cotangent in the reverse sweep; without a bound (`None`), the gradient is exact. Its norm counts
    /// cotangents of velocities in units of the [time scale](Lattice::time_scale).
    pub cotangent_bound: Option<CotangentBound>,
    /// If true, trajectories also have the [efforts](super::Trajectory::efforts) of the bars.
    pub metered: bool,
}

impl Span {
    /// A span that begins at time 0, observes all nodes, is not watched, and has exact gradients.
    pub fn from_start(observed: Vec<usize>) -> Self {
        Self {
            first: 0,
            observed,
            nodes: usize::MAX,
            watched: false,
            cotangent_bound: None,
            metered: false,
        }
    }

    /// The number of steps of the rollout.
    pub(crate) fn steps(&self) -> usize {
        self.observed.last().copied().unwrap_or(0)
    }
}

/// Simulates robots on one lattice, with the physics of a scene.
#[derive(Clone, Debug)]
pub struct Simulator {
    pub(super) lattice: Lattice,
    pub(super) robot: Robot,
    /// The length of a time step, s.
    pub(super) dt: f64,
    pub(super) ground: Ground,
    /// The largest allowed speed of a node, m/s: a guarded rollout with a faster node counts as diverged. `None` if
    /// there is no bound.
    pub(super) speed_bound: Option<f64>,
    /// For each step, its [pairs](Robot::pairs_at) of the clock and the goals, and then the time if a force reads it.
    pub(super) clock: Arc<[f64]>,
    /// The memory that a rollout may use to store states for its reverse sweep.
    pub memory: Memory,
    /// A flag that another thread may set to stop all rollouts. Their states and gradients are then NaN.
    pub stop: Option<Arc<AtomicBool>>,
}

impl Simulator {
    /// Prepares a simulator for rollouts of at most `physics.steps` steps.
    pub fn new(
        lattice: &Lattice,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        let robot = Robot::new(lattice, physics, controller);
        Self {
            lattice: lattice.clone(),
            dt: physics.dt,
            clock: inputs_of_steps(&robot, physics.dt, physics.steps),
            robot,
            ground: Ground::from(physics),
            speed_bound: physics.speed_bound,
            memory: Memory::All,
            stop: None,
        }
    }

    /// A copy of this simulator with this memory budget for the gradients of rollouts. The gradient does not depend on
    /// the budget.
    #[must_use]
    pub fn with_memory(self, memory: Memory) -> Self {
        Self { memory, ..self }
    }

    /// A copy of this simulator with another coefficient of friction, which has no effect if the contact law has no
    /// friction.
    #[must_use]
    pub fn with_friction(&self, friction: f64) -> Self {
        let mechanics = self.robot.mechanics.with_friction(friction);
        Self {
            robot: self.robot.with_mechanics(mechanics),
            ..self.clone()
        }
    }

    /// A copy of this simulator in which robots have these goals, in place of `controller.goal`. Their numbers are
    /// [surroundings](Self::surroundings) named `goal.0.along`, in space `goal.0.across`, `goal.0.above`, `goal.1.along` and
    /// so on, in metres, so that robots of one batch may have other goals, and rollouts can be differentiated with respect to them.
    ///
    /// # Panics
    /// If goals are not inputs of a rollout (`controller.goals = "given"`).
    #[must_use]
    pub fn with_goals(&self, goals: &Goals) -> Self {
        let before = self.robot.goals.as_ref();
        let before = before.expect("goals of a rollout need `controller.goals = \"given\"`");
        let robot = self.robot.with_goals(goals.clone());
        let clock = if goals.change_with(before) {
            Arc::clone(&self.clock)
        } else {
            let steps = self.clock.len() / self.robot.inputs_of_step();
            inputs_of_steps(&robot, self.dt, steps)
        };
        Self {
            clock,
            robot,
            ..self.clone()
        }
    }

    /// A copy of this simulator for robots without feedback: in every step, the policy sees the state `seen` instead of
    /// the current one. Only the clock that it sees advances.
    ///
    /// # Panics
    /// If the state does not fit the lattice.
    #[must_use]
    pub fn without_feedback(&self, seen: &State<f64>) -> Self {
        self.check(&[], &[seen]);
        Self {
            robot: self.robot.without_feedback(&self.flatten(seen)),
            ..self.clone()
        }
    }

    /// The surroundings of the scene, whose numbers are constants: gravity, friction, the settings of the laws, and the
    /// goals if they are inputs of a rollout.
    pub fn surroundings<R: Real>(&self) -> Surroundings<R> {
        Surroundings::of_scene(&self.robot.inputs)
    }

    /// Panics unless bodies and starts fit this lattice. Without this check, arrays for a larger lattice would be
    /// misread silently.
    pub(super) fn check<R: Real>(&self, bodies: &[Body<R>], starts: &[&State<R>]) {
        let (nodes, edges) = (self.lattice.nodes(), self.lattice.edges.len());
        let fits = |what: &str, found: usize, expected: usize| self.fits(what, found, expected);
        for body in bodies {
            fits("stiffness", body.stiffness.len(), edges);
            fits("strain", body.strain.len(), edges);
            fits("masses", body.mass.len(), nodes);
            if !body.presence.is_empty() {
                fits("presence", body.presence.len(), nodes);
            }
            if !body.rest_length.is_empty() {
                fits("rest lengths", body.rest_length.len(), edges);
            }
        }
        for start in starts {
            fits("initial positions", start.x.len(), nodes);
            fits("initial velocities", start.v.len(), nodes);
        }
    }

    /// Panics unless a controller fits this lattice.
    pub(super) fn check_controller<R: Real>(&self, controller: &Controller<R>) {
        let Drive::Policy(driver) = &self.robot.drive else {
            return;
        };
        let given: Vec<_> = controller.blocks().collect();
        self.fits("blocks of the controller", given.len(), driver.blocks.len());
        for ((name, shape, _), block) in given.into_iter().zip(&*driver.blocks) {
            assert_eq!(name, block.name, "the controller belongs to another policy");
            let what = format!("numbers of the controller in `{name}`");
            self.fits(&what, shape.len(), block.shape.len());
        }
    }

    /// Panics unless `found` is `expected`: the number of `what` (such as masses) that this lattice needs.
    #[track_caller]
    pub(super) fn fits(&self, what: &str, found: usize, expected: usize) {
        let nodes = self.lattice.nodes();
        assert_eq!(found, expected, "{what} of a robot of {nodes} nodes");
    }

    /// Converts a state in the world's frame to one flat array in the ground's frame.
    pub fn flatten<R: Real>(&self, state: &State<R>) -> Vec<R> {
        state.to_ground(&self.ground).to_columns()
    }

    /// Converts a flat array in the ground's frame to a state in the world's frame. The array has all nodes, or only
    /// the first nodes.
    pub(super) fn unflatten<R: Real>(&self, state: &[R]) -> State<R> {
        State::from_columns(self.lattice.dimension, state).to_world(&self.ground)
    }
}

/// The inputs of every step of a rollout, one step after the other.
fn inputs_of_steps(robot: &Robot, dt: f64, steps: usize) -> Arc<[f64]> {
    let timed = robot.mechanics.needs_time();
    let inputs = |step: usize| {
        // Each time is a product. A running sum would have growing rounding errors, and the phase reaches 164 rad.
        let time = step as f64 * dt;
        let pairs = robot.pairs_at(time, step).into_iter().flatten();
        pairs.chain(timed.then_some(time))
    };
    (0..steps).flat_map(inputs).collect()
}
