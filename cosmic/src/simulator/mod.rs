//! The simulator: from a body, a controller and a state to a trajectory.

mod trajectory;

pub use trajectory::Trajectory;
