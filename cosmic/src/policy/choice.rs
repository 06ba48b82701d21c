//! The policies that scenes choose by name.

use std::sync::Arc;

use super::block::{Block, Controller, Role, Shape};
use super::clock::Clock;
use super::gaits::Gaits;
use super::mlp::Mlp;
use super::step::{Policy, Sizes};
use super::tempo::TEMPO;
use crate::lattice::Lattice;
use crate::random::{self, Purpose};
use crate::registry::Registry;
use crate::scene::{ClockKind, ControllerSettings, ItemName};

impl Registry {
    /// Adds a policy. Scenes choose it by `controller.policy = "its_name"`.
    ///
    /// # Panics
    /// If the name is taken.
    #[must_use]
    pub fn with_policy(self, name: &'static str, policy: impl Policy + 'static) -> Self {
        let policy: Arc<dyn Policy> = Arc::new(policy);
        self.with(ItemName::POLICY, &ItemName::POLICIES, name, policy)
    }
}

/// The policy that a scene chooses.
pub fn of_settings(settings: &ControllerSettings) -> Arc<dyn Policy> {
    match settings.policy.item::<Arc<dyn Policy>>() {
        Some(policy) => Arc::clone(policy),
        None if settings.policy.name() == "clock" => Arc::new(Clock),
        None if settings.policy.name() == "gaits" => Arc::new(Gaits),
        None => Arc::new(Mlp),
    }
}

/// The blocks of a controller for a robot on this lattice: the blocks that the chosen policy declares, and [`TEMPO`] if
/// the clock is learned.
///
/// # Panics
/// If the clock is learned and the policy declares a block of that name.
pub fn blocks_of(settings: &ControllerSettings, lattice: &Lattice) -> Vec<Block> {
    let mut blocks = of_settings(settings).parameters(&Sizes {
        dimension: lattice.dimension,
        nodes: lattice.nodes(),
        edges: lattice.edges.len(),
        mirrored: lattice.mirror.as_ref().map(|mirror| mirror.sides),
        settings,
    });
    if settings.clock == ClockKind::Learned {
        assert!(
            blocks.iter().all(|block| block.name != TEMPO),
            "the policy `{}` has a block `{TEMPO}`, which is the name of the block of a learned clock; rename the \
             policy's block, or set `controller.clock` to \"fixed\"",
            settings.policy.name()
        );
        blocks.push(Block::biases(TEMPO, 1));
    }
    blocks
}

impl Controller<f64> {
    /// Draws the initial parameters of the policy that a scene chooses. The [role](Role) of each block decides how its
    /// numbers are drawn. Random weights follow X. Glorot and Y. Bengio, "Understanding the difficulty of training deep
    /// feedforward neural networks", AISTATS 2010, equation 16. They are multiplied by the gain of the block.
    pub fn xavier(settings: &ControllerSettings, lattice: &Lattice, seed: u64) -> Self {
        let blocks = blocks_of(settings, lattice);
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
