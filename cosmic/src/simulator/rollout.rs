//! [`Simulator`], which computes rollouts of robots.

use std::borrow::Borrow;
use std::fmt::Debug;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use autodiff::{CotangentBound, Given, Memory, Model, Real, Rollout};

use super::effort::{Effort, Efforts};
use super::parameters::Filled;
use super::robot::{Activations, Drive, Robot};
use super::surroundings::Surroundings;
use super::trajectory::{Still, Trajectory};
use crate::geometry::Ground;
use crate::lattice::{Body, Lattice, State};
use crate::policy::{Controller, Goals};
use crate::scene::{ControllerSettings, PhysicsSettings};

/// The unit of the cotangents of efforts in the bound on cotangents: so large that they do not count.
const NEGLIGIBLE: f64 = 1e30;

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
    /// If true, trajectories also have the [efforts](Trajectory::efforts) of the bars.
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
    clock: Arc<[f64]>,
    /// Equal for simulators that have the same steps, apart from the numbers of their surroundings.
    pub(super) identity: u64,
    /// The memory that a rollout may use to store states for its reverse sweep.
    pub memory: Memory,
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
            identity: identity_of(0, &(lattice, physics, controller)),
            memory: Memory::All,
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
    /// [surroundings](Self::surroundings) named `goal.0.along`, `goal.0.above`, `goal.0.is_point`, `goal.1.along` and so
    /// on, so that robots of one batch may have other goals, and rollouts can be differentiated with respect to them.
    /// With an `is_point` of 1, `along` and `above` are a point, in metres. With 0, `along` is a velocity, in m/s.
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
        let changes = goals.later.iter().map(|(steps, _)| steps);
        Self {
            clock,
            robot,
            identity: identity_of(self.identity, &changes.collect::<Vec<_>>()),
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
            identity: identity_of(self.identity, seen),
            ..self.clone()
        }
    }

    /// A copy of this simulator for robots whose activations are given, in place of a controller.
    pub(super) fn driven(&self) -> Self {
        Self {
            robot: self.robot.held(),
            ..self.clone()
        }
    }

    /// A copy of this simulator in which the controller sees its goal in the opposite direction. Goals that are inputs of a
    /// rollout stay as they are.
    #[must_use]
    pub fn turned_back(&self) -> Self {
        let mut other = self.clone();
        other.robot.settings = self.robot.settings.turned_back();
        other.identity = identity_of(self.identity, &"turned back");
        other
    }

    /// The surroundings of the scene, whose numbers are constants: gravity, friction, the settings of the laws, and the
    /// goals if they are inputs of a rollout.
    pub fn surroundings<R: Real>(&self) -> Surroundings<R> {
        Surroundings::of_scene(&self.robot.inputs)
    }

    /// Simulates a robot from the state `start` and returns the observed states. States are in the world's frame.
    ///
    /// # Panics
    /// If body, controller or state do not fit the lattice, if the span ends after the `physics.steps` that were given
    /// to [`new`](Self::new), or if the span observes no node.
    pub fn rollout<R: Real>(
        &self,
        body: &Body<R>,
        controller: &Controller<R>,
        start: &State<R>,
        span: &Span,
    ) -> Trajectory<R> {
        self.rollout_in(&self.surroundings(), body, controller, start, span)
    }

    /// Like [`rollout`](Simulator::rollout), in other [surroundings](Surroundings). The trajectory can be
    /// differentiated with respect to them.
    ///
    /// # Panics
    /// Like [`rollout`](Simulator::rollout), and if the surroundings are from a simulator with other laws.
    pub fn rollout_in<R: Real>(
        &self,
        surroundings: &Surroundings<R>,
        body: &Body<R>,
        controller: &Controller<R>,
        start: &State<R>,
        span: &Span,
    ) -> Trajectory<R> {
        let planned = self.planned(surroundings, body, controller, start);
        let seen = planned.metered(span).run(&self.flatten(start), self, span);
        self.trajectory(&seen, span, surroundings, body, start)
    }

    /// Simulates robots with one controller from several starts. `bodies` has one body for all starts, or one for each
    /// start. The result has the same bits as single [rollouts](Simulator::rollout). It takes less time, because the
    /// robots run in SIMD lanes and share each read of a weight.
    ///
    /// # Panics
    /// Like [`rollout`](Simulator::rollout), and if the number of bodies is neither one nor the number of starts.
    pub fn rollout_many<R: Real>(
        &self,
        bodies: &[Body<R>],
        controller: &Controller<R>,
        starts: &[impl Borrow<State<R>>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        self.rollout_many_in(&[self.surroundings()], bodies, controller, starts, span)
    }

    /// Like [`rollout_many`](Simulator::rollout_many), in other surroundings. `surroundings` has one entry for all
    /// starts, or one for each start.
    ///
    /// # Panics
    /// Like [`rollout_many`](Simulator::rollout_many); if the number of surroundings is neither one nor the number of
    /// starts; and if they are from a simulator with other laws.
    pub fn rollout_many_in<R: Real>(
        &self,
        surroundings: &[Surroundings<R>],
        bodies: &[Body<R>],
        controller: &Controller<R>,
        starts: &[impl Borrow<State<R>>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        if let ([surroundings], [body], [start]) = (surroundings, bodies, starts) {
            return vec![self.rollout_in(surroundings, body, controller, start.borrow(), span)];
        }
        let starts: Vec<&State<R>> = starts.iter().map(Borrow::borrow).collect();
        self.check(bodies, &starts);
        self.check_controller(controller);
        let model = self.robot.for_bodies(bodies).metered(span.metered);
        let numbers = self.numbers(&model, surroundings, bodies, Driving::By(controller));
        self.in_lanes(model, surroundings, bodies, &numbers, &starts, span)
    }

    /// The goals in these surroundings.
    fn goals_in<R: Real>(&self, surroundings: &Surroundings<R>) -> Option<Goals<R>> {
        let goals = self.robot.goals.as_ref()?;
        let goal = |k: usize| surroundings.goal(self.robot.mechanics.inputs.len(), k);
        let later = goals.later.iter().enumerate();
        Some(Goals {
            first: goal(0),
            later: later.map(|(k, &(steps, _))| (steps, goal(k + 1))).collect(),
        })
    }

    /// Simulates robots in SIMD lanes. `numbers` has the numbers of their parameters; `surroundings` and `bodies` have one
    /// entry for all starts, or one for each start.
    pub(super) fn in_lanes<R: Real>(
        &self,
        model: Robot,
        surroundings: &[Surroundings<R>],
        bodies: &[Body<R>],
        numbers: &[Vec<Vec<R>>],
        starts: &[&State<R>],
        span: &Span,
    ) -> Vec<Trajectory<R>> {
        let trajectory = |(k, seen): (usize, &Vec<R>)| {
            let surroundings = &surroundings[k % surroundings.len()];
            self.trajectory(
                seen,
                span,
                surroundings,
                &bodies[k % bodies.len()],
                starts[k],
            )
        };
        if let [start] = starts {
            let parameters = numbers.iter().flatten().cloned().collect();
            let seen = Planned { model, parameters }.run(&self.flatten(start), self, span);
            return vec![trajectory((0, &seen))];
        }
        let flat = |start: &&State<R>| model.started(self.flatten(start));
        let flat: Vec<Vec<R>> = starts.iter().map(flat).collect();
        let rollout = self.plan(model, span);
        let seen = run_together(&rollout, &slices(&flat), numbers);
        seen.iter().enumerate().map(trajectory).collect()
    }

    /// Computes the activation of every edge in several states. `moments` has each state with its time (s).
    pub(crate) fn activations(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        moments: &[(&State<f64>, f64)],
    ) -> Vec<Vec<f64>> {
        let bodies = std::slice::from_ref(body);
        self.check_controller(controller);
        let robot = self.robot.for_all_edges(bodies);
        let surroundings = [self.surroundings()];
        let numbers = self.numbers(&robot, &surroundings, bodies, Driving::By(controller));
        let slots = robot.graph.slots();
        let start = |(state, time): &(&State<f64>, f64)| {
            let clock = self
                .robot
                .pairs_at(*time, (time / self.dt).round() as usize);
            let clock = clock.concat();
            [self.flatten(state), clock, vec![0.0; slots]].concat()
        };
        let starts: Vec<Vec<f64>> = moments.iter().map(start).collect();
        let first = 4 * robot.graph.nodes() + 2 * robot.pairs();
        let slot_of_edge = robot.graph.slot_of_edge().to_vec();
        let rollout = Rollout {
            entries: Some((first..first + slots).collect()),
            ..Rollout::new(Activations(robot), 1)
        };
        let seen = run_together(&rollout, &slices(&starts), &numbers);
        let of_edges = |seen: Vec<f64>| slot_of_edge.iter().map(|&slot| seen[slot]).collect();
        seen.into_iter().map(of_edges).collect()
    }

    /// Like [`rollout`](Simulator::rollout), but without checkpoints and SIMD lanes. If the numbers are variables,
    /// every operation of every step becomes an entry of the tape, and cotangents are not limited. Tests and benchmarks
    /// compare the gradients of `rollout`, and their cost, with this method.
    ///
    /// # Panics
    /// Like [`rollout`](Simulator::rollout).
    pub fn rollout_in_full<R: Real>(
        &self,
        body: &Body<R>,
        controller: &Controller<R>,
        start: &State<R>,
        span: &Span,
    ) -> Trajectory<R> {
        let surroundings = self.surroundings();
        let planned = self.planned(&surroundings, body, controller, start);
        let Planned { model, parameters } = planned.metered(span);
        let start_of_all = model.started(self.flatten(start));
        let rollout = self.plan(model, span);
        let seen = rollout.unrolled(&start_of_all, &slices(&parameters));
        self.trajectory(&seen, span, &surroundings, body, start)
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
        }
        for start in starts {
            fits("initial positions", start.x.len(), nodes);
            fits("initial velocities", start.v.len(), nodes);
        }
    }

    /// Panics unless a controller fits this lattice.
    fn check_controller<R: Real>(&self, controller: &Controller<R>) {
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

    /// Describes the rollout of a robot over a span to `autodiff`.
    pub(super) fn plan(&self, model: Robot, span: &Span) -> Rollout<Robot> {
        assert!(
            span.nodes > 0,
            "`nodes` of a span is 0; it must be 1 or more"
        );
        let steps = span.steps();
        // A span that begins at the start shares the whole clock; a later span copies its part of the clock.
        let clock = match span.first {
            0 => Arc::clone(&self.clock),
            first => {
                let inputs = self.robot.inputs_of_step();
                self.clock[inputs * first..inputs * (first + steps)].into()
            }
        };
        let (nodes, meters) = (self.robot.graph.nodes(), model.meters());
        let entries = (0..4).flat_map(|k| (0..span.nodes).map(move |node| k * nodes + node));
        let entries = entries.chain(4 * nodes..4 * nodes + meters);
        Rollout {
            model,
            steps,
            inputs: clock,
            observed: span.observed.clone(),
            entries: (span.nodes < nodes).then(|| entries.collect()),
            state_bound: span.watched.then(|| self.watched()),
            cotangent_bound: span.cotangent_bound,
            cotangent_units: self.cotangent_units(meters),
            memory: self.memory,
        }
    }

    /// The units in which the norm of a state's cotangent is compared with its bound: the cotangents of velocities are
    /// divided by the [time scale](Lattice::time_scale) of the lattice. Those of the `meters` numbers of the efforts do not
    /// count. `None` if no cotangent has a unit.
    fn cotangent_units(&self, meters: usize) -> Option<Arc<[f64]>> {
        let time = self.lattice.time_scale();
        let half = 2 * self.lattice.nodes();
        (time != 1.0 || meters > 0).then(|| {
            let units = [(1.0, half), (time, half), (NEGLIGIBLE, meters)];
            let units = units.into_iter();
            units
                .flat_map(|(unit, count)| std::iter::repeat_n(unit, count))
                .collect()
        })
    }

    /// Prepares a robot for a body: leaves out the parts that the body does not need, and collects the numbers of the
    /// parameters.
    pub(super) fn planned<R: Real>(
        &self,
        surroundings: &Surroundings<R>,
        body: &Body<R>,
        controller: &Controller<R>,
        start: &State<R>,
    ) -> Planned<R> {
        let surroundings = std::slice::from_ref(surroundings);
        let bodies = std::slice::from_ref(body);
        self.check(bodies, &[start]);
        self.check_controller(controller);
        let model = self.robot.for_bodies(bodies);
        let numbers = self.numbers(&model, surroundings, bodies, Driving::By(controller));
        Planned {
            model,
            parameters: numbers.into_iter().flatten().collect(),
        }
    }

    /// The numbers of all parameters: for each parameter one list per robot, or one list that all robots share.
    pub(super) fn numbers<R: Real>(
        &self,
        robot: &Robot,
        surroundings: &[Surroundings<R>],
        bodies: &[Body<R>],
        driving: Driving<R>,
    ) -> Vec<Vec<Vec<R>>> {
        let (of_starts, controller) = match driving {
            Driving::By(controller) => (Vec::new(), Some(controller)),
            Driving::Held(activations) => (activations, None),
        };
        let fits = |given: &Surroundings<R>| given.fits(&self.robot.inputs);
        assert!(
            surroundings.iter().all(fits),
            "the surroundings are from a simulator with other laws or goals"
        );
        let mut filled = Filled {
            bodies,
            surroundings,
            of_starts,
            numbers: Vec::new(),
        };
        robot.parameters(&mut filled);
        let of_policy = controller.map(|c| robot.policy_numbers(c, &self.ground));
        let of_policy = of_policy.into_iter().flatten().map(|shared| vec![shared]);
        filled.numbers.into_iter().chain(of_policy).collect()
    }

    /// Converts the observed states to a trajectory. `seen` has the states as flat arrays, one after the other.
    pub(super) fn trajectory<R: Real>(
        &self,
        seen: &[R],
        span: &Span,
        surroundings: &Surroundings<R>,
        body: &Body<R>,
        start: &State<R>,
    ) -> Trajectory<R> {
        let still = Still::of(body, start);
        let of_nodes = 4 * self.robot.graph.nodes().min(span.nodes);
        let meters = self.robot.meters_if(span.metered);
        let states = || seen.chunks_exact(of_nodes + meters);
        let efforts = || Efforts {
            of_states: (states().map(|s| self.effort(&s[of_nodes..]))).collect(),
            body: body.clone(),
            dt: self.dt,
        };
        Trajectory {
            steps: span.observed.clone(),
            states: (states().map(|s| still.held(self.unflatten(&s[..of_nodes])))).collect(),
            efforts: span.metered.then(efforts),
            marker: body.marker.clone(),
            start: (body.marker.weights.first()).map_or(Vec::new(), |_| start.x.clone()),
            goals: (self.goals_in(surroundings)).map(|goals| goals.after(span.first)),
        }
    }

    /// The efforts of all edges, from their numbers in a flat state.
    pub(super) fn effort<R: Real>(&self, of_slots: &[R]) -> Effort<R> {
        Effort::of_slots(of_slots, self.robot.graph.slot_of_edge())
    }

    /// Converts a state in the world's frame to one flat array in the ground's frame.
    pub fn flatten<R: Real>(&self, state: &State<R>) -> Vec<R> {
        state.to_ground(&self.ground).to_columns()
    }

    /// Converts a flat array in the ground's frame to a state in the world's frame. The array has all nodes, or only
    /// the first nodes.
    pub(super) fn unflatten<R: Real>(&self, state: &[R]) -> State<R> {
        State::from_columns(state).to_world(&self.ground)
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

/// A number that identifies `what` and the number before it.
fn identity_of(before: u64, what: &impl Debug) -> u64 {
    let mut hasher = DefaultHasher::new();
    (before, format!("{what:?}")).hash(&mut hasher);
    hasher.finish()
}

/// The source of the activations in a rollout.
pub(super) enum Driving<'a, R> {
    /// A policy, whose parameters are in this controller.
    By(&'a Controller<R>),
    /// Constant activations: for each start, a list with one activation per slot of the graph.
    Held(Vec<Vec<R>>),
}

/// Runs a rollout from several starts. Each parameter in `numbers` has one list per start, or one list that all starts
/// share.
fn run_together<M: Model, R: Real>(
    rollout: &Rollout<M>,
    starts: &[&[R]],
    numbers: &[Vec<Vec<R>>],
) -> Vec<Vec<R>> {
    let numbers: Vec<Vec<&[R]>> = numbers.iter().map(|p| slices(p)).collect();
    let given = numbers.iter().map(|of_starts| match of_starts[..] {
        [shared] => Given::Shared(shared),
        _ => Given::Each(of_starts),
    });
    rollout.run_batch(starts, &given.collect::<Vec<_>>())
}

/// A robot that is prepared for rollouts, and the values of its parameters.
pub(super) struct Planned<R> {
    pub(super) model: Robot,
    pub(super) parameters: Vec<Vec<R>>,
}

impl<R: Real> Planned<R> {
    /// A copy whose steps record efforts if the span asks for them.
    pub(super) fn metered(self, span: &Span) -> Self {
        Self {
            model: self.model.metered(span.metered),
            ..self
        }
    }

    /// Simulates from a flat start state and returns the observed states as one list, one state after the other. If the
    /// state has no efforts, they start at 0.
    pub(super) fn run(&self, start: &[R], simulator: &Simulator, span: &Span) -> Vec<R> {
        let rollout = simulator.plan(self.model.clone(), span);
        let start = self.model.started(start.to_vec());
        rollout.run(&start, &slices(&self.parameters))
    }
}

fn slices<R>(of: &[Vec<R>]) -> Vec<&[R]> {
    of.iter().map(Vec::as_slice).collect()
}
