//! The recorded step of robots and the numbers that it reads, for programs that run the step elsewhere.

use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Model, Rollout};

use super::base::World;
use super::parameters::ParameterSink;
use super::robot::{Robot, shared};
use super::span::Span;
use super::step::RobotStep;
use super::trajectory::Trajectory;
use crate::geometry::Dimension;
use crate::lattice::Body;
use crate::laws::StepInput;

/// The walk of robots as `autodiff_programs` sees it, with conversions of robots to its numbers and back. The package
/// `cosmic-gpu` prints its step.
///
/// [`World::recorded`] makes it.
#[derive(Clone, Debug)]
pub struct RecordedRobots {
    world: World,
    rollout: Rollout<RobotStep>,
    span: Span,
}

/// The source of a parameter of a robot's step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The body.
    Body,
    /// The controller.
    Controller,
    /// The surroundings.
    Surroundings,
    /// The scene: all robots have the same numbers.
    Scene,
}

impl World {
    /// The walk of robots over a span. The step leaves out the edges without stiffness or stroke in all of these bodies,
    /// unless it has `all_edges`: with derivatives by bodies, such an edge has derivatives too.
    ///
    /// # Panics
    /// Like [`run`](Self::run), and if the robots have different steps: some given activations and others a policy, goals that
    /// change at different steps, or different largest strains.
    pub fn recorded(&self, robots: &[Robot<f64>], span: &Span, all_edges: bool) -> RecordedRobots {
        self.check(robots);
        let differs = |pair: &[Robot<f64>]| !pair[0].steps_like(&pair[1]);
        if let Some(before) = robots.windows(2).position(differs) {
            panic!(
                "robots {before} and {} have different steps; robots that are recorded together must all have given \
                 activations or all a policy, goals that change at the same steps, and the same largest strain",
                before + 1
            );
        }
        let bodies = shared(robots.iter().map(|robot| Arc::clone(&robot.body)));
        let step = match all_edges {
            true => self.step_of(robots).for_all_edges(&bodies),
            false => self.step_of(robots).for_bodies(&bodies),
        };
        RecordedRobots {
            rollout: self.plan(step.metered(span.metered), span),
            world: self.clone(),
            span: span.clone(),
        }
    }
}

impl RecordedRobots {
    /// The rollout. Its model records the step.
    pub fn rollout(&self) -> &Rollout<impl Model + Clone> {
        &self.rollout
    }

    /// The span of the walk.
    pub fn span(&self) -> &Span {
        &self.span
    }

    /// The sources of the first parameters of the step. All parameters after these are the controller's.
    pub fn sources(&self) -> Vec<Source> {
        let mut sources = Sources(Vec::new());
        self.rollout.model.parameters(&mut sources);
        sources.0
    }

    /// The numbers of the step's parameters: for each parameter one list per robot, or one list that all robots share.
    ///
    /// # Panics
    /// If the robots are from a world with other laws or goals.
    pub fn numbers<R: Real>(&self, robots: &[Robot<R>]) -> Vec<Vec<Vec<R>>> {
        (self.world).numbers(&self.rollout.model, robots, self.span.steps())
    }

    /// The start of a robot as the numbers of the step's state.
    pub fn start<R: Real>(&self, robot: &Robot<R>) -> Vec<R> {
        self.rollout.model.started(self.world.flatten(&robot.start))
    }

    /// The trajectory of a robot, from its observed numbers.
    pub fn trajectory<R: Real>(&self, seen: &[R], robot: &Robot<R>) -> Trajectory<R> {
        self.world.trajectory(seen, &self.span, robot)
    }
}

/// Collects the sources of a robot's parameters in the order of declaration.
struct Sources(Vec<Source>);

impl ParameterSink for Sources {
    type Number = f64;
    type Array = ();

    fn of_body(&mut self, _: usize, _: impl Fn(&Body<f64>) -> Vec<f64>) {
        self.0.push(Source::Body);
    }
    fn of_surroundings(&mut self, _: &[StepInput], _: impl Fn(&[f64]) -> Vec<f64>) {
        self.0.push(Source::Surroundings);
    }
    fn of_goal(&mut self, _: usize, _: Dimension) {
        self.0.push(Source::Surroundings);
    }
    fn of_step(&mut self, _: usize) {
        self.0.push(Source::Scene);
    }
    fn shared(&mut self, _: &[f64]) {
        self.0.push(Source::Scene);
    }
}
