//! How the walks of robots are described to `autodiff`: their steps, and the numbers of their parameters.

use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Given, Model, Rollout};

use super::base::World;
use super::parameters::Filled;
use super::robot::{Robot, shared};
use super::span::Span;
use super::step::RobotStep;

/// The unit of the cotangents of efforts in the bound on cotangents: so large that they do not count.
const NEGLIGIBLE: f64 = 1e30;

/// Robots that are prepared for a walk in the same lanes.
pub(super) struct Planned<R> {
    pub(super) model: RobotStep,
    /// The numbers of each parameter: one list per robot, or one list that all robots share.
    pub(super) numbers: Vec<Vec<Vec<R>>>,
}

impl World {
    /// Prepares robots that [walk together](Robot::walks_with): leaves out the parts that none of them needs, and collects
    /// the numbers of the parameters.
    ///
    /// # Panics
    /// If the robots do not fit this world.
    pub(super) fn planned<R: Real>(&self, robots: &[Robot<R>], span: &Span) -> Planned<R> {
        self.check(robots);
        let bodies = shared(robots.iter().map(|robot| Arc::clone(&robot.body)));
        let mut model = self.step_of(robots).for_bodies(&bodies);
        model = model.metered(span.metered);
        if let Some(seen) = &span.open_loop {
            model = model.without_feedback(&self.flatten(seen));
        }
        let numbers = self.numbers(&model, robots, span.steps());
        Planned { model, numbers }
    }

    /// The step of these robots: with their goals, and with activations that are given if their controllers state them.
    pub(super) fn step_of<R: Real>(&self, robots: &[Robot<R>]) -> RobotStep {
        let Some(first) = robots.first() else {
            return self.step.clone();
        };
        let step = self.step.with_goals(first.surroundings.goals.as_ref());
        match first.controller.activations() {
            Some(_) => step.driven(),
            None => step,
        }
    }

    /// The numbers of all parameters in a walk of `steps` steps: for each parameter one list per robot, or one list that all
    /// robots share.
    pub(super) fn numbers<R: Real>(
        &self,
        model: &RobotStep,
        robots: &[Robot<R>],
        steps: usize,
    ) -> Vec<Vec<Vec<R>>> {
        let bodies = shared(robots.iter().map(|robot| Arc::clone(&robot.body)));
        let surroundings = shared(robots.iter().map(|robot| Arc::clone(&robot.surroundings)));
        assert!(
            surroundings.iter().all(|given| self.step.can_read(given)),
            "the surroundings are from a world with other laws or goals"
        );
        let controllers = shared(robots.iter().map(|robot| Arc::clone(&robot.controller)));
        let given = controllers.iter().filter_map(|controller| {
            let given = controller.activations()?;
            Some(self.activations_of_steps(model, given, steps))
        });
        let mut filled = Filled {
            bodies: &bodies,
            surroundings: &surroundings,
            of_steps: given.collect(),
            numbers: Vec::new(),
        };
        model.parameters(&mut filled);
        let mut numbers = filled.numbers;
        let first = numbers.len();
        for controller in controllers {
            if controller.activations().is_none() {
                self.check_controller(&controller);
            }
            let of_policy = model.policy_numbers(&controller, &self.ground);
            numbers.resize(first + of_policy.len(), Vec::new());
            for (lists, list) in numbers[first..].iter_mut().zip(of_policy) {
                lists.push(list);
            }
        }
        numbers
    }

    /// Given activations of each step and slot of the graph. `given` has those of each step and edge, or those of each edge
    /// if they stay constant.
    fn activations_of_steps<R: Real>(
        &self,
        model: &RobotStep,
        given: &[R],
        steps: usize,
    ) -> Vec<R> {
        let edges = self.lattice.edges.len();
        let is_constant = given.len() == edges;
        self.fits(
            "activations",
            given.len(),
            if is_constant { edges } else { edges * steps },
        );
        let of_step = |step| if is_constant { 0 } else { edges * step };
        let steps = (0..steps).map(|step| &given[of_step(step)..][..edges]);
        steps.flat_map(|step| model.graph.to_slots(step)).collect()
    }

    /// Describes a walk over a span to `autodiff`.
    pub(super) fn plan(&self, model: RobotStep, span: &Span) -> Rollout<RobotStep> {
        assert!(
            span.nodes > 0,
            "`nodes` of a span is 0; it must be 1 or more"
        );
        let (steps, of_step) = (span.steps(), model.inputs_of_step());
        // Goals that change at other steps than those of the scene change the inputs of the steps.
        let whole = match self.step.changes_with(&model) {
            true => Arc::clone(&self.clock),
            false => {
                let all = self.clock.len() / self.step.inputs_of_step();
                model.inputs_of_steps(self.physics.dt, all)
            }
        };
        // A span that begins at the start shares the whole clock; a later span copies its part of the clock.
        let clock = match span.first {
            0 => whole,
            first => whole[of_step * first..of_step * (first + steps)].into(),
        };
        let (nodes, meters) = (model.graph.nodes(), model.meters());
        let of_nodes = model.numbers_of_nodes();
        let columns = (0..of_nodes).step_by(nodes);
        let entries = columns.flat_map(|column| (0..span.nodes).map(move |node| column + node));
        let entries = entries.chain(of_nodes..of_nodes + meters);
        Rollout {
            steps,
            inputs: clock,
            observed: span.observed.clone(),
            entries: (span.nodes < nodes).then(|| entries.collect()),
            state_bound: span.watched.then(|| self.watched()),
            cotangent_bound: span.cotangent_bound,
            cotangent_units: self.cotangent_units(meters),
            memory: span.memory,
            stop: span.stop.clone(),
            model,
        }
    }

    /// The units in which the norm of a state's cotangent is compared with its bound: the cotangents of velocities are
    /// divided by the [time scale](crate::lattice::Lattice::time_scale) of the lattice. Those of the `meters` numbers of the
    /// efforts do not count. `None` if no cotangent has a unit.
    fn cotangent_units(&self, meters: usize) -> Option<Arc<[f64]>> {
        let time = self.lattice.time_scale();
        let half = self.step.numbers_of_nodes() / 2;
        (time != 1.0 || meters > 0).then(|| {
            let units = [(1.0, half), (time, half), (NEGLIGIBLE, meters)];
            let units = units.into_iter();
            units
                .flat_map(|(unit, count)| std::iter::repeat_n(unit, count))
                .collect()
        })
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

impl<R: Real> Planned<R> {
    /// Simulates from flat start states. Returns the observed states of each start as one list, one state after the other.
    /// If a start has no efforts, they start at 0.
    pub(super) fn run(&self, starts: Vec<Vec<R>>, world: &World, span: &Span) -> Vec<Vec<R>> {
        let started = starts.into_iter().map(|start| self.model.started(start));
        let starts: Vec<Vec<R>> = started.collect();
        let rollout = world.plan(self.model.clone(), span);
        run_together(&rollout, &slices(&starts), &self.numbers)
    }
}

pub(super) fn slices<R>(of: &[Vec<R>]) -> Vec<&[R]> {
    of.iter().map(Vec::as_slice).collect()
}
