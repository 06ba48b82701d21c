//! [`OnDevice`], the device that an optimisation uses in place of the processor.

use std::sync::{Arc, OnceLock};

use crate::design::{Design, Mixture};
use crate::domain::Domain;
use crate::policy::Controller;
use crate::population::{Batch, GradientBatch, Populations, Refused, RobotGradient};
use crate::simulator::{Span, Trajectory};

/// A device, and the error with which it stopped working. After an error no result counts; whoever iterates asks for it.
pub(super) struct OnDevice {
    pub(super) populations: Arc<dyn Populations>,
    failed: OnceLock<Refused>,
}

impl OnDevice {
    pub(super) fn new(populations: Arc<dyn Populations>) -> Self {
        Self {
            populations,
            failed: OnceLock::new(),
        }
    }

    /// The error, if there was one.
    pub(super) fn failed(&self) -> Option<&Refused> {
        self.failed.get()
    }

    /// Notes an error.
    fn noted<T>(&self, result: Result<T, Refused>) -> Option<T> {
        result
            .map_err(|error| self.failed.get_or_init(|| error))
            .ok()
    }

    pub(super) fn gradients(&self, asked: &[GradientBatch]) -> Option<Vec<Vec<RobotGradient>>> {
        self.noted(self.populations.gradients(asked))
    }

    /// Simulates the robots of some populations.
    pub(super) fn rollouts(&self, asked: &[Batch]) -> Option<Vec<Vec<Trajectory<f64>>>> {
        self.noted(self.populations.rollouts(asked))
    }

    /// Simulates robots in several domains; see [`rollouts`](crate::domain::rollouts).
    pub(super) fn roll(
        &self,
        designs: &[&Design<Mixture<f64>>],
        controller: &Controller<f64>,
        domains: &[Domain],
        span: &Span,
    ) -> Option<Vec<Trajectory<f64>>> {
        let asked = batch_of(designs, controller, domains, span);
        Some(self.rollouts(&[asked])?.remove(0))
    }
}

/// Robots with one controller, each in its own domain. `designs` has one design for all domains, or one for each.
pub(super) fn batch_of(
    designs: &[&Design<Mixture<f64>>],
    controller: &Controller<f64>,
    domains: &[Domain],
    span: &Span,
) -> Batch {
    let surroundings = domains
        .iter()
        .map(|domain| domain.task.simulator.surroundings());
    let bodies = domains.iter().enumerate();
    let bodies = bodies.map(|(k, domain)| domain.task.body(designs[k % designs.len()]));
    Batch {
        simulator: domains[0].task.simulator.clone(),
        span: span.clone(),
        surroundings: surroundings.collect(),
        bodies: bodies.collect(),
        // Each robot has its own, so that robots of other optimisations can join them.
        controllers: vec![controller.clone(); domains.len()],
        starts: domains.iter().map(|domain| domain.start.clone()).collect(),
    }
}
