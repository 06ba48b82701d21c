//! How a robot's rollout is described to `autodiff`: its steps, and the numbers of its parameters.

use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Given, Model, Rollout};

use super::parameters::Filled;
use super::prepare::{Simulator, Span};
use super::robot::Robot;
use super::surroundings::Surroundings;
use crate::lattice::{Body, State};
use crate::policy::Controller;

/// Robots on one lattice, for rollouts on the processor or on a GPU.
#[derive(Clone, Copy, Debug)]
pub struct Robots<'a, R> {
    /// Gravity, friction, the settings of laws, and the goals. One for all robots, or one for each.
    pub surroundings: &'a [Surroundings<R>],
    /// One for all robots, or one for each.
    pub bodies: &'a [Body<R>],
    /// One for all robots, or one for each.
    pub controllers: &'a [Controller<R>],
}

impl<'a, R> Robots<'a, R> {
    /// A single robot.
    pub fn one(
        surroundings: &'a Surroundings<R>,
        body: &'a Body<R>,
        controller: &'a Controller<R>,
    ) -> Self {
        Self {
            surroundings: std::slice::from_ref(surroundings),
            bodies: std::slice::from_ref(body),
            controllers: std::slice::from_ref(controller),
        }
    }

    /// The surroundings, the body and the controller of robot `k`.
    pub fn member(&self, k: usize) -> (&'a Surroundings<R>, &'a Body<R>, &'a Controller<R>) {
        let (surroundings, body) = self.body(k);
        (
            surroundings,
            body,
            &self.controllers[k % self.controllers.len()],
        )
    }

    /// The surroundings and the body of robot `k`, which may have no controller.
    pub fn body(&self, k: usize) -> (&'a Surroundings<R>, &'a Body<R>) {
        (
            &self.surroundings[k % self.surroundings.len()],
            &self.bodies[k % self.bodies.len()],
        )
    }

    /// Panics unless there is one entry of each kind, or one for each start.
    pub(super) fn check(&self, starts: usize, is_driven: bool) {
        let counts = [
            ("surroundings", self.surroundings.len()),
            ("bodies", self.bodies.len()),
            ("controllers", self.controllers.len()),
        ];
        // Robots with given activations have no controllers.
        for (what, count) in counts.into_iter().take(if is_driven { 2 } else { 3 }) {
            assert!(
                count == 1 || count == starts,
                "{count} {what} for {starts} starts; expected one for all, or one for each"
            );
        }
        let mut strains = self.bodies.iter().map(|body| body.largest_strain);
        let first = strains.next();
        assert!(
            strains.all(|strain| Some(strain) == first),
            "the actuator materials of the bodies have different largest strains"
        );
    }
}

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
        let of_nodes = self.robot.numbers_of_nodes();
        let columns = (0..of_nodes).step_by(nodes);
        let entries = columns.flat_map(|column| (0..span.nodes).map(move |node| column + node));
        let entries = entries.chain(of_nodes..of_nodes + meters);
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
        let half = self.robot.numbers_of_nodes() / 2;
        (time != 1.0 || meters > 0).then(|| {
            let units = [(1.0, half), (time, half), (NEGLIGIBLE, meters)];
            let units = units.into_iter();
            units
                .flat_map(|(unit, count)| std::iter::repeat_n(unit, count))
                .collect()
        })
    }

    /// Prepares robots for rollouts: leaves out the parts that none of their bodies needs, and collects the numbers of the
    /// parameters. If `metered` is true, steps record the efforts of the bars. The robots must share one controller.
    pub(super) fn planned<R: Real>(
        &self,
        robots: &Robots<R>,
        starts: &[&State<R>],
        metered: bool,
    ) -> Planned<R> {
        self.check(robots.bodies, starts);
        let controllers = robots.controllers.iter();
        controllers.for_each(|controller| self.check_controller(controller));
        let model = self.robot.for_bodies(robots.bodies).metered(metered);
        let numbers = self.numbers(&model, robots, Vec::new());
        Planned { model, numbers }
    }

    /// The numbers of all parameters: for each parameter one list per robot, or one list that all robots share. `activations`
    /// has those of each start, one per step and slot of the graph, for robots that are driven by them.
    pub(super) fn numbers<R: Real>(
        &self,
        model: &Robot,
        robots: &Robots<R>,
        activations: Vec<Vec<R>>,
    ) -> Vec<Vec<Vec<R>>> {
        let fits = |given: &Surroundings<R>| given.fits(&self.robot.inputs);
        assert!(
            robots.surroundings.iter().all(fits),
            "the surroundings are from a simulator with other laws or goals"
        );
        let mut filled = Filled {
            bodies: robots.bodies,
            surroundings: robots.surroundings,
            of_steps: activations,
            numbers: Vec::new(),
        };
        model.parameters(&mut filled);
        let mut numbers = filled.numbers;
        let first = numbers.len();
        for controller in robots.controllers {
            let of_policy = model.policy_numbers(controller, &self.ground);
            numbers.resize(first + of_policy.len(), Vec::new());
            for (lists, list) in numbers[first..].iter_mut().zip(of_policy) {
                lists.push(list);
            }
        }
        numbers
    }
}

/// Runs a rollout from several starts. Each parameter in `numbers` has one list per start, or one list that all starts
/// share.
pub(super) fn run_together<M: Model + Clone, R: Real>(
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

/// Robots that are prepared for rollouts.
pub(super) struct Planned<R> {
    pub(super) model: Robot,
    /// The numbers of each parameter: one list per robot, or one list that all robots share.
    pub(super) numbers: Vec<Vec<Vec<R>>>,
}

impl<R: Real> Planned<R> {
    /// Simulates from flat start states. Returns the observed states of each start as one list, one state after the other.
    /// If a start has no efforts, they start at 0.
    pub(super) fn run(
        &self,
        starts: Vec<Vec<R>>,
        simulator: &Simulator,
        span: &Span,
    ) -> Vec<Vec<R>> {
        let started = starts.into_iter().map(|start| self.model.started(start));
        let starts: Vec<Vec<R>> = started.collect();
        let rollout = simulator.plan(self.model.clone(), span);
        run_together(&rollout, &slices(&starts), &self.numbers)
    }
}

pub(super) fn slices<R>(of: &[Vec<R>]) -> Vec<&[R]> {
    of.iter().map(Vec::as_slice).collect()
}
