//! The open-loop clock: a network that sees clocks and goal, and nothing of the robot.

use autodiff::Array;

use super::block::Block;
use super::mlp::{blocks, record};
use super::policy::{Policy, Sizes};
use super::sensing::Sight;
use super::step::PolicyStep;

/// The network of [`Mlp`](super::Mlp) without the robot in its observation: it moves all robots alike,
/// wherever they are.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock;

impl Policy for Clock {
    fn parameters(&self, robot: &Sizes) -> Vec<Block> {
        blocks(robot, robot.observation(Sight::Clock))
    }

    fn observe(&self) -> Sight {
        Sight::Clock
    }

    fn record(&self, step: &mut PolicyStep) -> Array {
        record(step)
    }
}
