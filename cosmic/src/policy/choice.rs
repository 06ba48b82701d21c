//! The policies that scenes choose by name.

use std::sync::Arc;

use super::block::{Block, Controller, Role, Shape};
use super::clock::Clock;
use super::mlp::Mlp;
use super::policy::{Policy, Sizes};
use crate::lattice::Lattice;
use crate::random::{self, Purpose};
use crate::registry::Registry;
use crate::scene::{Chosen, ControllerSettings};

impl Registry {
    /// Adds a policy. Scenes choose it by `controller.policy = "its_name"`.
    ///
    /// # Panics
    /// If the name is taken.
    #[must_use]
    pub fn with_policy(self, name: &'static str, policy: impl Policy + 'static) -> Self {
        let policy: Arc<dyn Policy> = Arc::new(policy);
        self.with(Chosen::POLICY, &Chosen::POLICIES, name, policy)
    }
}

/// The policy that a scene chooses.
pub fn of_settings(settings: &ControllerSettings) -> Arc<dyn Policy> {
    match settings.policy.item::<Arc<dyn Policy>>() {
        Some(policy) => Arc::clone(policy),
        None if settings.policy.name() == "clock" => Arc::new(Clock),
        None => Arc::new(Mlp),
    }
}

/// The blocks that the chosen policy declares for a robot with `nodes` nodes and `edges` edges.
pub fn blocks_of(settings: &ControllerSettings, nodes: usize, edges: usize) -> Vec<Block> {
    of_settings(settings).parameters(&Sizes {
        nodes,
        edges,
        settings,
    })
}

impl Controller<f64> {
    /// Draws the initial parameters of the policy that a scene chooses. The [role](Role) of each block decides how its
    /// numbers are drawn. Random weights follow X. Glorot and Y. Bengio, "Understanding the difficulty of training deep
    /// feedforward neural networks", AISTATS 2010, equation 16. They are multiplied by the gain of the block.
    pub fn xavier(settings: &ControllerSettings, lattice: &Lattice, seed: u64) -> Self {
        let blocks = blocks_of(settings, lattice.nodes(), lattice.edges.len());
        let mut stream = random::stream(seed, Purpose::Weights);
        let mut numbers = Vec::new();
        for Block { shape, role, .. } in &blocks {
            let len = shape.len();
            let limit = match (role, *shape) {
                (Role::Biases, _) => {
                    numbers.resize(numbers.len() + len, 0.0);
                    continue;
                }
                (Role::Weights { gain }, Shape::Matrix { rows, columns }) => {
                    gain * (6.0 / (rows + columns) as f64).sqrt()
                }
                (Role::Weights { gain }, Shape::Vector(len)) => gain * (6.0 / len as f64).sqrt(),
            };
            numbers.extend((0..len).map(|_| random::symmetric(&mut stream, limit)));
        }
        Self::new(&blocks, numbers)
    }
}
