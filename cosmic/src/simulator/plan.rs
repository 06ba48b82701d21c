//! How a robot's rollout is described to `autodiff`: its steps, and the numbers of its parameters.

use std::sync::Arc;

use autodiff::{Given, Model, Real, Rollout};

use super::parameters::Filled;
use super::prepare::{Simulator, Span};
use super::robot::Robot;
use super::surroundings::Surroundings;
use crate::lattice::{Body, State};
use crate::policy::Controller;

/// The unit of the cotangents of efforts in the bound on cotangents: so large that they do not count.
const NEGLIGIBLE: f64 = 1e30;

impl Simulator {
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
            stop: self.stop.clone(),
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
pub(super) fn run_together<M: Model, R: Real>(
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

pub(super) fn slices<R>(of: &[Vec<R>]) -> Vec<&[R]> {
    of.iter().map(Vec::as_slice).collect()
}
