//! Populations of robots, which a device such as a GPU simulates together in single precision.
//!
//! The trait [`Populations`] is the interface between optimisations and devices. The package `cosmic-gpu` implements it. A
//! `Batcher` joins the requests of several optimisations.

#[cfg(feature = "files")]
mod batcher;

use std::fmt;
use std::sync::Arc;

#[cfg(feature = "files")]
pub use batcher::{Batcher, Client};

use crate::geometry::Vector;
use crate::lattice::{Body, State};
use crate::objective::AnyLoss;
use crate::policy::Controller;
use crate::simulator::{Robots, Simulator, Span, Surroundings, Trajectory, Wanted};

/// Robots that one simulator simulates over one span, each from its own start.
#[derive(Clone, Debug)]
pub struct Batch {
    /// The simulator.
    pub simulator: Simulator,
    /// The span of the rollouts.
    pub span: Span,
    /// One for all robots, or one for each.
    pub surroundings: Vec<Surroundings<f64>>,
    /// One for all robots, or one for each.
    pub bodies: Vec<Body<f64>>,
    /// One for all robots, or one for each.
    pub controllers: Vec<Controller<f64>>,
    /// The start of each robot.
    pub starts: Vec<State<f64>>,
}

impl Batch {
    /// The robots.
    pub fn robots(&self) -> Robots<'_, f64> {
        Robots {
            surroundings: &self.surroundings,
            bodies: &self.bodies,
            controllers: &self.controllers,
        }
    }
}

/// Robots whose losses are differentiated.
#[derive(Clone)]
pub struct GradientBatch {
    /// The robots.
    pub of: Batch,
    /// The inputs by which their losses are differentiated: bodies, controllers, or neither.
    pub by: Wanted,
    /// The loss.
    pub loss: Arc<dyn AnyLoss>,
    /// The positions from which the displacement of each robot counts; empty if these are the starts.
    pub origins: Vec<Vec<Vector<f64>>>,
}

/// The loss of a robot and its derivatives.
#[derive(Clone, Debug)]
pub struct RobotGradient {
    /// The loss.
    pub loss: f64,
    /// The trajectory.
    pub trajectory: Trajectory<f64>,
    /// The derivatives by the numbers of the body; zeros unless they are wanted.
    pub body: Body<f64>,
    /// The derivatives by the numbers of the controller; zeros unless they are wanted.
    pub controller: Vec<f64>,
}

/// The reason why a device cannot simulate a population, as a sentence without a full stop.
pub type Refused = String;

impl fmt::Debug for dyn Populations {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_tuple("Populations").field(&self.name()).finish()
    }
}

/// Simulates populations of robots in single precision and differentiates their losses.
///
/// The result of a robot must not depend on the other robots. If a span is [watched](Span::watched), and a state of a
/// robot fails the check, all observations of this robot must be NaN.
pub trait Populations: Send + Sync {
    /// The name of the device, for messages.
    fn name(&self) -> String;

    /// Checks that the device can simulate robots like these, and differentiate by the inputs `by` if it is not `None`.
    ///
    /// # Errors
    /// If it cannot.
    fn check(&self, asked: &Batch, by: Option<Wanted>) -> Result<(), Refused>;

    /// Computes the rollouts of several populations, in their order.
    ///
    /// # Errors
    /// If the device stopped working, or if [`check`](Self::check) would refuse.
    fn rollouts(&self, asked: &[Batch]) -> Result<Vec<Vec<Trajectory<f64>>>, Refused>;

    /// Computes the losses of several populations and their derivatives, in their order.
    ///
    /// # Errors
    /// Like [`rollouts`](Self::rollouts).
    fn gradients(&self, asked: &[GradientBatch]) -> Result<Vec<Vec<RobotGradient>>, Refused>;
}
