//! One step of a robot, recorded as operations on arrays.

use std::sync::Arc;

use autodiff::{Parameters, Real};
use autodiff_programs::{Array, Graph, Model, Program};

use super::effort::{Effort, Meter};
use super::mechanics::{Actuation, Mechanics};
use super::parameters::{Named, ParameterSink, StepParameters};
use super::surroundings::Surroundings;
use crate::geometry::{Axes, Dimension, Ground};
use crate::lattice::{Body, Lattice, Mirror};
use crate::laws::{Motion, StepInput};
use crate::policy::{
    self, Block, BlockSource, Controller, Fold, Goals, Hold, Mean, Outputs, Pick, Policy,
    PolicyStep, Seen, Turn, ahead, blocks_of, ticks,
};
use crate::scene::{ControllerSettings, GoalKind, PhysicsSettings};

/// The step of the robots of a world, as a [`Model`]. The model declares these arrays, in this order:
///
/// - Parameters: the fields of [`StepParameters`], then the input of [`Turn`] if the clock is learned, then the parameters
///   of the policy.
/// - State: the components of the positions of all nodes, then those of the velocities, in the ground's frame.
/// - Inputs: the [pairs](RobotStep::pairs) of the clock and of the goals, and `t` if a force reads it.
#[derive(Clone, Debug)]
pub(super) struct RobotStep {
    pub(super) graph: Graph,
    /// The mirror image of the robot, if the robot is its own image.
    mirror: Option<Arc<Mirror>>,
    /// The slots of the graph whose edges get an activation from the policy, ascending.
    actuated: Vec<usize>,
    /// The rest length of the edge in every slot, m.
    rest_length: Vec<f64>,
    pub(super) drive: Drive,
    /// The scene's section `controller`.
    pub(super) settings: ControllerSettings,
    /// The goals of the robots, which may be at other places but change at the same steps; `None` if the goal is a number
    /// of the controller.
    goals: Option<Goals>,
    /// The names of the numbers of the surroundings that the mechanics read, and their values in the scene.
    pub(super) inputs: Arc<[StepInput]>,
    /// True if bodies state the presence of their nodes.
    has_presence: bool,
    /// True if bodies state the rest lengths of their edges.
    has_rest_lengths: bool,
    /// The largest strain of the actuator material.
    largest_strain: f64,
    /// For a robot without feedback: the state that the policy sees in every step, as columns.
    seen: Option<Arc<[f64]>>,
    pub(super) mechanics: Mechanics,
    /// True if a step also records the [efforts](super::Effort) of the bars.
    pub(super) is_metered: bool,
}

/// The source of a robot's activations.
#[derive(Clone, Debug)]
pub(super) enum Drive {
    /// A policy, which computes the activations in every step.
    Policy(Driver),
    /// Given activations, one per step and slot of the graph.
    Given,
}

/// A policy, with the blocks of numbers of a controller and the parameters that the policy declares.
#[derive(Clone, Debug)]
pub(super) struct Driver {
    policy: Arc<dyn Policy>,
    pub(super) blocks: Arc<[Block]>,
    /// The sources of the parameters that the policy declares when it is recorded.
    sources: Arc<[BlockSource]>,
}

impl RobotStep {
    pub(super) fn new(
        lattice: &Lattice,
        physics: &PhysicsSettings,
        controller: &ControllerSettings,
    ) -> Self {
        let graph = lattice.graph();
        let mut actuated = graph.slot_of_edge().to_vec();
        actuated.sort_unstable();
        let mut robot = Self {
            rest_length: graph.to_slots(&lattice.rest_length),
            graph,
            mirror: lattice.mirror.clone().map(Arc::new),
            actuated,
            drive: Drive::Given,
            settings: controller.clone(),
            goals: (controller.goals == GoalKind::Given).then(|| Goals::at(controller.goal)),
            inputs: Arc::new([]),
            has_presence: false,
            has_rest_lengths: false,
            largest_strain: 1.0,
            seen: None,
            mechanics: Mechanics::new(lattice, physics),
            is_metered: false,
        };
        robot.drive = Drive::Policy(robot.driver(blocks_of(controller, lattice)));
        let mut named = Named::default();
        robot.mechanics.parameters(&mut named);
        robot.inputs = named.0.into();
        robot
    }

    /// The policy that the settings choose, with its blocks. It is recorded once here, to find out which parameters it
    /// declares.
    fn driver(&self, blocks: Vec<Block>) -> Driver {
        let settings = &self.settings;
        let mut driver = Driver {
            policy: policy::of_settings(settings),
            blocks: blocks.into(),
            sources: Arc::new([]),
        };
        let p = &mut Program::default();
        let seen = Seen {
            nodes: self.state(p),
            rest_length: p.state(self.graph.slots()),
            clock: p.input(2),
            presence: None,
            goal: (self.goals.as_ref()).map(|_| p.state(self.mechanics.dimension.count())),
        };
        let (_, sources) = driver.record(p, settings, seen, self.outputs());
        driver.sources = sources.into();
        driver
    }

    /// A copy of this robot without the parts that none of these bodies needs: the edges without stiffness, which never
    /// pull, and the outputs of the policy for edges without stiffness or with a strain of 0.
    pub(super) fn for_bodies<R: Real>(&self, bodies: &[Arc<Body<R>>]) -> Self {
        let mut robot = self.for_all_edges(bodies);
        let slack = |edge: usize| bodies.iter().all(|body| body.stiffness[edge].is_zero());
        let slack: Vec<bool> = (0..self.graph.slot_of_edge().len()).map(slack).collect();
        if slack.contains(&true) {
            robot.graph = self.graph.without(&slack);
        }
        let edges = robot.graph.edge_of_slot();
        let strains = |edge: usize| bodies.iter().any(|body| !body.strain[edge].is_zero());
        robot
            .actuated
            .retain(|&slot| edges[slot].is_some_and(strains));
        robot
    }

    /// A copy of this robot with all of its edges, and with the largest strain of these bodies. If one of them states the
    /// presence of its nodes or the rest lengths of its edges, the steps use them.
    pub(super) fn for_all_edges<R: Real>(&self, bodies: &[Arc<Body<R>>]) -> Self {
        Self {
            has_presence: bodies.iter().any(|body| !body.presence.is_empty()),
            has_rest_lengths: bodies.iter().any(|body| !body.rest_length.is_empty()),
            largest_strain: bodies.first().map_or(1.0, |body| body.largest_strain),
            ..self.clone()
        }
    }

    /// A copy of this robot whose policy sees the flat state `seen` in every step, in place of the current state.
    pub(super) fn without_feedback(&self, seen: &[f64]) -> Self {
        Self {
            seen: Some(seen.into()),
            ..self.clone()
        }
    }

    /// A copy of this robot whose steps record the efforts of its bars if `is_metered` is true.
    pub(super) fn metered(self, is_metered: bool) -> Self {
        Self { is_metered, ..self }
    }

    /// The number of numbers of the efforts in a state.
    pub(super) fn meters(&self) -> usize {
        self.meters_if(self.is_metered)
    }

    /// The number of numbers of the efforts in a state, if steps record them.
    pub(super) fn meters_if(&self, is_metered: bool) -> usize {
        match is_metered {
            true => Effort::<f64>::LISTS * self.graph.slots(),
            false => 0,
        }
    }

    /// The number of numbers of the nodes in a state.
    pub(super) fn numbers_of_nodes(&self) -> usize {
        2 * self.mechanics.dimension.count() * self.graph.nodes()
    }

    /// A flat state of the nodes, with efforts of 0 unless it has efforts already.
    pub(super) fn started<R: Real>(&self, mut state: Vec<R>) -> Vec<R> {
        state.resize(self.numbers_of_nodes() + self.meters(), R::zero());
        state
    }

    /// A copy of this robot with given activations in place of a policy.
    pub(super) fn driven(self) -> Self {
        Self {
            drive: Drive::Given,
            ..self
        }
    }

    /// Declares the state of the nodes.
    fn state(&self, p: &mut Program) -> Motion {
        let [x, v] = [(); 2]
            .map(|()| Axes::from_fn(self.mechanics.dimension, |_| p.state(self.graph.nodes())));
        Motion { x, v }
    }

    /// A copy of this robot whose goals change at the steps of these.
    pub(super) fn with_goals<R: Real>(&self, goals: Option<&Goals<R>>) -> Self {
        Self {
            goals: goals.map(|goals| goals.map(R::primal)),
            ..self.clone()
        }
    }

    /// True if the goals of the other robot change at the same steps.
    pub(super) fn changes_with(&self, other: &Self) -> bool {
        self.goals.as_ref().map(Goals::changes) == other.goals.as_ref().map(Goals::changes)
    }

    /// True if the surroundings have the numbers that a step reads.
    pub(super) fn can_read<R: Real>(&self, surroundings: &Surroundings<R>) -> bool {
        surroundings.fits(&self.inputs, self.goals.is_some())
    }

    /// The pairs of numbers that a step gets at the time `time` (s), after `steps` steps: the [ticks](ticks()) of the
    /// clock, then the numbers that say which [goal holds](Goals::holds).
    pub(super) fn pairs_at(&self, time: f64, steps: usize) -> Vec<[f64; 2]> {
        let mut pairs = ticks(&self.settings, time);
        pairs.extend(self.goals.iter().flat_map(|goals| goals.holds(steps)));
        pairs
    }

    /// The number of [pairs](Self::pairs_at) that a step gets.
    pub(super) fn pairs(&self) -> usize {
        self.pairs_at(0.0, 0).len()
    }

    /// The number of numbers that a step gets.
    pub(super) fn inputs_of_step(&self) -> usize {
        2 * self.pairs() + usize::from(self.mechanics.needs_time())
    }

    /// The inputs of every step of a walk, one step after the other.
    pub(super) fn inputs_of_steps(&self, dt: f64, steps: usize) -> Arc<[f64]> {
        let timed = self.mechanics.needs_time();
        let inputs = |step: usize| {
            // Each time is a product. A running sum would have growing rounding errors, and the phase reaches 164 rad.
            let time = step as f64 * dt;
            let pairs = self.pairs_at(time, step).into_iter().flatten();
            pairs.chain(timed.then_some(time))
        };
        (0..steps).flat_map(inputs).collect()
    }

    fn outputs(&self) -> Outputs<'_> {
        Outputs {
            graph: &self.graph,
            actuated: &self.actuated,
            mirror: self.mirror.as_deref(),
        }
    }

    /// Lists the parameters of the robot in `p`, in the order of declaration. The parameters of the policy are not
    /// included; they come after these.
    pub(super) fn parameters<P: ParameterSink>(&self, p: &mut P) -> StepParameters<P::Array> {
        let (graph, slots, nodes) = (&self.graph, self.graph.slots(), self.graph.nodes());
        let inverse = |mass: &P::Number| mass.recip();
        let mechanics = self.mechanics.parameters(p);
        let goals = 0..self.goals.as_ref().map_or(0, Goals::count);
        StepParameters {
            goals: goals
                .map(|k| p.of_goal(k, self.mechanics.dimension))
                .collect(),
            mechanics,
            stiffness: p.of_body(slots, |body| graph.to_slots(&body.stiffness)),
            rest_length: match self.has_rest_lengths {
                true => p.of_body(slots, |body| graph.to_slots(&body.rest_length)),
                false => p.shared(&self.rest_length),
            },
            strain: p.of_body(slots, |body| graph.to_slots(&body.strain)),
            largest_strain: self.largest_strain,
            inverse_mass: p.of_body(nodes, |body| body.mass.iter().map(inverse).collect()),
            presence: match (self.has_presence, &self.goals) {
                (true, _) => Some(p.of_body(nodes, |body| body.presence.clone())),
                // A given goal is observed from the mean position, which a step computes with weights.
                (false, Some(_)) => Some(p.shared(&vec![1.0; nodes])),
                (false, None) => None,
            },
            activation: matches!(self.drive, Drive::Given).then(|| p.of_step(slots)),
            seen: (self.seen.as_ref()).map(|seen| {
                let mut columns = seen.chunks_exact(nodes);
                let mut next = |_| p.shared(columns.next().expect("a column for each component"));
                [(); 2].map(|()| Axes::from_fn(self.mechanics.dimension, &mut next))
            }),
        }
    }

    /// The numbers of the learned clock's parameter and of the policy's parameters, which are the same for all bodies.
    pub(super) fn policy_numbers<R: Real>(
        &self,
        controller: &Controller<R>,
        ground: &Ground,
    ) -> Vec<Vec<R>> {
        let Drive::Policy(driver) = &self.drive else {
            return Vec::new();
        };
        if self.actuated.is_empty() {
            return Vec::new();
        }
        let mean = if self.has_presence || self.goals.is_some() {
            Mean::InStep
        } else {
            Mean::OfAll
        };
        let (settings, sight) = (&self.settings, driver.policy.observe());
        let nodes = (self.mechanics.dimension, self.graph.nodes());
        let fold = Fold::new(settings, ground, nodes, sight, mean);
        let (fold, outputs) = (fold.without_constants(), self.outputs());
        let sources = driver.sources.iter();
        let of_policy = sources.map(|source| source.numbers(controller, &fold, &outputs));
        let of_clock = ahead(settings, controller).map(|ahead| vec![ahead]);
        of_clock.into_iter().chain(of_policy).collect()
    }

    /// Records the activation of every slot as a function of the state and the [ticks](ticks()) of the clock. If the
    /// robot has no actuators, activations have no effect: the policy is not recorded, and any array of the right length
    /// is returned.
    pub(super) fn activation(
        &self,
        p: &mut Program,
        given: &StepParameters<Array>,
        state: Motion,
        clock: &[Array],
    ) -> Array {
        let driver = match &self.drive {
            Drive::Given => {
                return given
                    .activation
                    .expect("a robot with given activations declares them");
            }
            Drive::Policy(_) if self.actuated.is_empty() => return given.strain,
            Drive::Policy(driver) => driver,
        };
        let (ticks, legs) = clock.split_at(ticks(&self.settings, 0.0).len());
        let clock = match *ticks {
            [clock, slope, phase] => {
                let ahead = p.parameter(1);
                p.map(Turn, [clock, slope, phase], &[ahead])[0]
            }
            _ => ticks[0],
        };
        // Only one goal holds and all others add zeros, so the sums have the bits of that goal.
        let pairs = given.goals.iter().zip(legs);
        let sum = pairs.fold(None, |sum: Option<Array>, (&goal, &holds)| {
            let holds = match self.mechanics.dimension {
                Dimension::Plane => holds,
                Dimension::Space => p.gather(holds, &[Some(0); 3]),
            };
            let [sum] = match sum {
                None => p.map(Hold, [goal, holds], &[]),
                Some(sum) => p.map(Pick, [sum, goal, holds], &[]),
            };
            Some(sum)
        });
        // A single goal always holds.
        let goal = sum.or(given.goals.first().copied());
        let seen = Seen {
            nodes: given.seen.map_or(state, |[x, v]| Motion { x, v }),
            rest_length: given.rest_length,
            clock,
            presence: given.presence,
            goal,
        };
        let (activation, _) = driver.record(p, &self.settings, seen, self.outputs());
        activation
    }
}

impl Driver {
    /// Records the policy. Returns the activation of every slot, and the sources of the parameters that the policy declares.
    fn record(
        &self,
        p: &mut Program,
        settings: &ControllerSettings,
        seen: Seen,
        outputs: Outputs,
    ) -> (Array, Vec<BlockSource>) {
        let sees = (self.policy.observe(), settings);
        let mut step = PolicyStep::new(p, &self.blocks, sees, seen, outputs);
        let activation = self.policy.record(&mut step);
        (activation, step.into_sources())
    }
}

impl Model for RobotStep {
    fn record(&self, p: &mut Program) {
        let given = self.parameters(p);
        let state = self.state(p);
        let efforts = (self.is_metered).then(|| [(); 4].map(|()| p.state(self.graph.slots())));
        let clock: Vec<Array> = (0..self.pairs()).map(|_| p.input(2)).collect();
        let time = self.mechanics.needs_time().then(|| p.input(1));

        // 1. The policy observes the state.
        let activation = self.activation(p, &given, state, &clock);

        // 2. Every edge pulls on its nodes, and every node moves; the contact law acts where a node meets the ground.
        let at_nodes = vec![Some(0); self.graph.nodes()];
        let time = time.map(|time| p.gather(time, &at_nodes));
        let mechanics = &self.mechanics;
        let mut meter = efforts.map(|[_, tension, work, net]| Meter { tension, work, net });
        let meters = meter.as_mut();
        let actuation = Actuation { activation, time };
        let next = mechanics.record(p, &self.graph, state, &given, actuation, meters);
        for (state, next) in state.list().into_iter().zip(next.list()) {
            p.advance(state, next);
        }
        if let (Some(efforts), Some(Meter { tension, work, net })) = (efforts, meter) {
            for (effort, next) in efforts.into_iter().zip([activation, tension, work, net]) {
                p.advance(effort, next);
            }
        }
    }
}

/// A model that only evaluates the policy. Its state consists of the state of the nodes, the clock, and a number for
/// every slot of the graph. A step replaces the numbers of the slots by their activations; everything else stays the
/// same.
#[derive(Clone, Debug)]
pub(super) struct Activations(pub(super) RobotStep);

impl Model for Activations {
    fn record(&self, p: &mut Program) {
        let given = self.0.parameters(p);
        let state = self.0.state(p);
        let clock: Vec<Array> = (0..self.0.pairs()).map(|_| p.state(2)).collect();
        let before = p.state(self.0.graph.slots());
        let activation = self.0.activation(p, &given, state, &clock);
        for part in state.list().into_iter().chain(clock) {
            p.advance(part, part);
        }
        p.advance(before, activation);
    }
}
