//! Robots as programs for a GPU: the text of their step, and the numbers that it reads.

use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::wgsl::{self, Options, Printed, Refused};

use super::base::World;
use super::parameters::ParameterSink;
use super::robot::{Robot, shared};
use super::span::Span;
use super::step::RobotStep;
use super::trajectory::Trajectory;
use crate::lattice::Body;
use crate::laws::StepInput;

/// A population of robots on one lattice, for rollouts on a GPU. Its members may differ in body, controller,
/// surroundings and start; what all of them share is shared on the GPU too.
///
/// [`World::printed`] makes it. It prints the step once, and converts robots to the numbers that the printed program
/// reads, and back: `cosmic-gpu` has the devices.
#[derive(Clone, Debug)]
pub struct PrintedRobots {
    /// The printed program.
    pub program: Printed,
    /// The inputs of all steps of the span, one step after the other.
    pub inputs: Arc<[f64]>,
    /// For each parameter, whether all members share it.
    common: Vec<bool>,
    world: World,
    step: RobotStep,
    span: Span,
}

/// The cotangents that a reverse sweep computes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The cotangents of the bodies.
    pub bodies: bool,
    /// The cotangents of the controllers.
    pub controllers: bool,
    /// The cotangents of the surroundings.
    pub surroundings: bool,
}

/// The workgroup that carries one robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Workgroup {
    /// The number of its invocations.
    pub invocations: usize,
    /// Its memory, in bytes. Numbers of a step that do not fit lie in a buffer, which is slower.
    pub memory: usize,
}

impl From<usize> for Workgroup {
    /// A workgroup of this many invocations, with memory for any step.
    fn from(invocations: usize) -> Self {
        Self {
            invocations,
            memory: usize::MAX,
        }
    }
}

impl World {
    /// Prints the step of these robots for a GPU. The numbers of a later population may be others, but the edges without
    /// stiffness or stroke in all of these bodies are left out, and what these robots share stays shared. With one member
    /// nothing counts as different.
    ///
    /// # Errors
    /// If the step cannot be printed. An implicit step cannot, because it solves linear equations.
    ///
    /// # Panics
    /// Like [`run`](World::run).
    pub fn printed(
        &self,
        robots: &[Robot<f64>],
        span: &Span,
        wanted: Wanted,
        workgroup: impl Into<Workgroup>,
    ) -> Result<PrintedRobots, Refused> {
        let workgroup = workgroup.into();
        self.check(robots);
        let bodies = shared(robots.iter().map(|robot| Arc::clone(&robot.body)));
        // A part without stiffness or strain has derivatives with respect to these numbers.
        let step = match wanted.bodies {
            true => self.step_of(robots).for_all_edges(&bodies),
            false => self.step_of(robots).for_bodies(&bodies),
        };
        let step = step.metered(span.metered);
        let plan = self.plan(step.clone(), span);
        let numbers = self.numbers(&step, robots, span.steps());
        let common: Vec<bool> = numbers.iter().map(|lists| lists.len() == 1).collect();
        let mut kinds = Kinds(Vec::new());
        step.parameters(&mut kinds);
        let kind = |k: usize| kinds.0.get(k).copied().unwrap_or(Kind::Controller);
        let is_wanted = |k: &usize| match kind(*k) {
            Kind::Body => wanted.bodies,
            Kind::Surroundings => wanted.surroundings,
            Kind::Controller => wanted.controllers,
            Kind::Fixed => false,
        };
        let chosen = |k: &usize| common[*k];
        let options = Options {
            workgroup: workgroup.invocations,
            memory: workgroup.memory,
            common: (0..common.len()).filter(chosen).collect(),
            wanted: (0..common.len()).filter(is_wanted).collect(),
            entries: plan.entries.clone(),
            state_bound: plan.state_bound,
            cotangent_bound: plan.cotangent_bound,
            cotangent_units: plan.cotangent_units.clone(),
            ..Options::default()
        };
        Ok(PrintedRobots {
            program: wgsl::print(&step, &options)?,
            inputs: plan.inputs,
            common,
            world: self.clone(),
            step,
            span: span.clone(),
        })
    }
}

impl PrintedRobots {
    /// The numbers of the parameters, in the order of [`Printed::parameters`]: of each parameter its list, or the lists of
    /// all members one after the other.
    ///
    /// # Panics
    /// If the robots do not fit those with which the program was printed.
    pub fn numbers<R: Real>(&self, robots: &[Robot<R>]) -> Vec<Vec<R>> {
        let numbers = self.world.numbers(&self.step, robots, self.span.steps());
        let fits = numbers
            .iter()
            .map(|lists| lists.len() == 1)
            .eq(self.common.iter().copied());
        assert!(
            fits,
            "these robots share other numbers than those for which the program was printed"
        );
        numbers.iter().map(|lists| lists.concat()).collect()
    }

    /// The numbers of the parameters of a single member: a list for each, in the order of [`Printed::parameters`].
    pub fn numbers_of_one<R: Real>(&self, robot: &Robot<R>) -> Vec<Vec<R>> {
        let one = std::slice::from_ref(robot);
        let numbers = self.world.numbers(&self.step, one, self.span.steps());
        numbers.into_iter().flatten().collect()
    }

    /// The states at the start as the numbers of the program, one member after the other.
    pub fn starts<R: Real>(&self, robots: &[Robot<R>]) -> Vec<R> {
        let starts = robots.iter();
        starts
            .flat_map(|robot| self.step.started(self.world.flatten(&robot.start)))
            .collect()
    }

    /// The trajectory of a member, from the numbers that the program has observed of it.
    pub fn trajectory<R: Real>(&self, seen: &[R], robot: &Robot<R>) -> Trajectory<R> {
        self.world.trajectory(seen, &self.span, robot)
    }

    /// The span of the rollouts.
    pub fn span(&self) -> &Span {
        &self.span
    }
}

/// The source of a parameter.
#[derive(Clone, Copy)]
enum Kind {
    Body,
    Surroundings,
    Controller,
    Fixed,
}

/// Collects the kinds of a robot's parameters in the order of declaration.
struct Kinds(Vec<Kind>);

impl ParameterSink for Kinds {
    type Number = f64;
    type Array = ();

    fn of_body(&mut self, _: usize, _: impl Fn(&Body<f64>) -> Vec<f64>) {
        self.0.push(Kind::Body);
    }
    fn of_surroundings(&mut self, _: &[StepInput], _: impl Fn(&[f64]) -> Vec<f64>) {
        self.0.push(Kind::Surroundings);
    }
    fn of_step(&mut self, _: usize) {
        self.0.push(Kind::Fixed);
    }
    fn shared(&mut self, _: &[f64]) {
        self.0.push(Kind::Fixed);
    }
}
