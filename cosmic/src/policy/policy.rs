//! The trait of policies.

use std::fmt::Debug;

use autodiff::Array;

use super::block::Block;
use super::sensing::Sight;
use super::step::PolicyStep;
use crate::scene::ControllerSettings;

/// The robot that a policy is for.
#[derive(Clone, Copy, Debug)]
pub struct Sizes<'a> {
    /// Nodes of the lattice.
    pub nodes: usize,
    /// Edges of the lattice: each has an activation.
    pub edges: usize,
    /// The scene's section `controller`.
    pub settings: &'a ControllerSettings,
}

impl Sizes<'_> {
    /// The length of an observation.
    pub fn observation(&self, sight: Sight) -> usize {
        sight.length(self.settings, self.nodes)
    }
}

/// What turns the state of a robot into activations of its edges.
///
/// A policy declares its parameters and records one step. Rollouts, gradients, optimisation and files follow.
/// `cosmic/program/examples/rhythm.rs` is a policy of one's own.
pub trait Policy: Debug + Send + Sync {
    /// The blocks of its parameters. Names are keys in files: lower case letters, digits and underscores.
    fn parameters(&self, robot: &Sizes) -> Vec<Block>;

    /// What [an observed layer](PolicyStep::observed_layer) sees.
    fn observe(&self) -> Sight {
        Sight::Robot
    }

    /// Records the activations of a step: an array with a number from -1 to 1 for each edge, as
    /// [`PolicyStep::output_layer`] returns it, or a kernel mapped over arrays [per
    /// edge](PolicyStep::per_edge).
    fn record(&self, step: &mut PolicyStep) -> Array;
}
