//! The policies that scenes choose by name.

use std::sync::Arc;

use super::block::{Block, Controller, Role, Shape};
use super::clock::Clock;
use super::mlp::Mlp;
use super::policy::{Policy, Sizes};
use crate::lattice::Lattice;
use crate::random::{self, Purpose};
use crate::registry::Registry;
use crate::scene::{ControllerSettings, PolicyName};

/// The policies that were added to those of this crate.
static ADDED: Registry<Arc<dyn Policy>> = Registry::new();

/// Makes a policy known to all scenes that this process reads from now on, which choose it by
/// `controller.policy = "its_name"`.
///
/// # Panics
/// If the name is taken.
pub fn add(name: &'static str, policy: impl Policy + 'static) {
    PolicyName::add(name);
    ADDED.add("policy", name, Arc::new(policy));
}

/// The policy that a scene chooses.
pub fn of_settings(settings: &ControllerSettings) -> Arc<dyn Policy> {
    match settings.policy.name() {
        PolicyName::MLP => Arc::new(Mlp),
        PolicyName::CLOCK => Arc::new(Clock),
        name => (ADDED.get(name)).expect("a name is read only once its policy is known"),
    }
}

/// The blocks of the policy that a scene chooses, for a lattice of so many nodes and edges.
pub fn blocks_of(settings: &ControllerSettings, nodes: usize, edges: usize) -> Vec<Block> {
    of_settings(settings).parameters(&Sizes {
        nodes,
        edges,
        settings,
    })
}

impl Controller<f64> {
    /// The parameters with which a policy starts, by the [role](Role) of each block. Weights are drawn from a seed:
    /// X. Glorot and Y. Bengio, "Understanding the difficulty of training deep feedforward neural networks",
    /// AISTATS 2010, equation 16, which has no gain.
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
