//! The controller: clocks, goal and the robot's own motion in, one activation per edge out.

mod sensing;
mod network;
mod fold;
mod weights;

pub use network::Controller;
pub use sensing::{clock, observation, observation_length};
pub use weights::Weights;
