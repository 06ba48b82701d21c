//! The simulator: from a body, a controller and a state to a trajectory.

mod physics;
mod trajectory;

pub use physics::{Contact, Physics};
pub use trajectory::Trajectory;
