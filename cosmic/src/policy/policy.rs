//! The trait that every policy implements.

use std::fmt::Debug;

use autodiff::Array;

use super::block::Block;
use super::sensing::Sight;
use super::step::PolicyStep;
use crate::scene::ControllerSettings;

/// The properties of a robot that determine the parameters of its policy.
#[derive(Clone, Copy, Debug)]
pub struct Sizes<'a> {
    /// The number of nodes.
    pub nodes: usize,
    /// The number of edges. A policy computes one activation per edge.
    pub edges: usize,
    /// True if the robot is its own mirror image, front and back (`lattice.mirror`).
    pub is_mirrored: bool,
    /// The section `controller` of the scene.
    pub settings: &'a ControllerSettings,
}

impl Sizes<'_> {
    /// The number of entries in an observation of this robot.
    pub fn observation(&self, sight: Sight) -> usize {
        sight.length(self.settings, self.nodes)
    }
}

/// A policy computes the activations of the edges from the state of a robot.
///
/// A policy declares its parameters and records one step. Nothing more is needed for rollouts, gradients, optimisation
/// and files. `cosmic/program/examples/rhythm.rs` is an example.
pub trait Policy: Debug + Send + Sync {
    /// The blocks of the parameters. The name of a block is its key in files. It consists of lower case letters, digits
    /// and underscores. [`TEMPO`](super::TEMPO) is the name of the block of a learned clock.
    fn parameters(&self, robot: &Sizes) -> Vec<Block>;

    /// What the policy observes: the content of the input of [an observed layer](PolicyStep::observed_layer).
    fn observe(&self) -> Sight {
        Sight::Robot
    }

    /// Records how a step computes the activations. Returns an array with a number from -1 to 1 for each edge: the
    /// result of [`PolicyStep::output_layer`], or of a kernel mapped over arrays [per edge](PolicyStep::per_edge).
    fn record(&self, step: &mut PolicyStep) -> Array;
}
