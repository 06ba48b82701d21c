//! Robots as programs for a GPU: the text of their step, and the numbers that it reads.

use autodiff::Real;
use cosmic::world::{RecordedRobots, Robot, Source, Span, World};

use crate::wgsl::{self, Options, Printed, Refused};

/// A population of robots on one lattice, for rollouts on a GPU. Its members may differ in body, controller,
/// surroundings and start; what all of them share is shared on the GPU too.
///
/// The step is printed once. [`RobotsOnGpu`](crate::RobotsOnGpu) compiles it.
#[derive(Clone, Debug)]
pub struct PrintedRobots {
    /// The printed program.
    pub program: Printed,
    /// The rollout of the robots, with conversions of robots to the numbers of the program and back.
    pub(crate) recorded: RecordedRobots,
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

impl PrintedRobots {
    /// Prints the step of these robots for a GPU. The numbers of a later population may be others, but the edges without
    /// stiffness or stroke in all of these bodies are left out, and what these robots share stays shared. With one member
    /// nothing counts as different.
    ///
    /// # Errors
    /// If the step cannot be printed. An implicit step cannot, because it solves linear equations.
    ///
    /// # Panics
    /// Like [`World::run`].
    pub fn new(
        world: &World,
        robots: &[Robot<f64>],
        span: &Span,
        wanted: Wanted,
        workgroup: impl Into<Workgroup>,
    ) -> Result<Self, Refused> {
        let workgroup = workgroup.into();
        // A part without stiffness or strain has derivatives with respect to these numbers.
        let recorded = world.recorded(robots, span, wanted.bodies);
        let numbers = recorded.numbers(robots);
        let common: Vec<bool> = numbers.iter().map(|lists| lists.len() == 1).collect();
        let sources = recorded.sources();
        let source = |k: usize| sources.get(k).copied().unwrap_or(Source::Controller);
        let is_wanted = |k: &usize| match source(*k) {
            Source::Body => wanted.bodies,
            Source::Surroundings => wanted.surroundings,
            Source::Controller => wanted.controllers,
            Source::Scene => false,
        };
        let chosen = |k: &usize| common[*k];
        let rollout = recorded.rollout();
        let options = Options {
            workgroup: workgroup.invocations,
            memory: workgroup.memory,
            common: (0..common.len()).filter(chosen).collect(),
            wanted: (0..common.len()).filter(is_wanted).collect(),
            entries: rollout.entries.clone(),
            state_bound: rollout.state_bound,
            cotangent_bound: rollout.cotangent_bound,
            cotangent_units: rollout.cotangent_units.clone(),
            ..Options::default()
        };
        Ok(Self {
            program: wgsl::print(&rollout.model, &options)?,
            recorded,
        })
    }

    /// The numbers of the parameters of a single member: a list for each, in the order of [`Printed::parameters`].
    pub(crate) fn numbers_of_one<R: Real>(&self, robot: &Robot<R>) -> Vec<Vec<R>> {
        let numbers = self.recorded.numbers(std::slice::from_ref(robot));
        numbers.into_iter().flatten().collect()
    }

    /// The span of the rollouts.
    pub fn span(&self) -> &Span {
        self.recorded.span()
    }
}
