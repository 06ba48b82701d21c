//! The open-loop policy: a network that observes the clocks and the goal, but not the robot.

use autodiff_programs::Array;

use super::block::Block;
use super::mlp::{blocks, record};
use super::sensing::Sight;
use super::step::{Policy, PolicyStep, Sizes};

/// The network of [`Mlp`](super::Mlp) in open loop: its observation does not include the robot. Its activations depend
/// only on the time.
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
