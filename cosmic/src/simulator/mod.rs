//! The simulator: from a body, a controller and a state to a trajectory.
//!
//! The physics is in [`laws`](crate::laws), and the order of a step in `robot` and `mechanics`, once for every number
//! type. A rollout computes in the ground's frame, where contact is the sign of one coordinate. Callers pass and get
//! states in the world's frame.

mod surroundings;
mod parameters;
mod mechanics;
mod robot;
mod energy;
pub mod stability;
mod step_check;
mod trajectory;
mod rollout;
mod driven;
mod blame;
mod divergence;
mod overflow;
mod loads;

pub use blame::Cause;
pub use divergence::{Divergence, Guarded};
pub use driven::Driven;
pub use energy::Store;
pub use loads::{BarLoad, EdgeMoments, Loads, Magnitude};
pub use overflow::Overflow;
pub use rollout::{Simulator, Span};
pub use step_check::{Grade, StepCheck, StepLimit, rounded_down};
pub use surroundings::Surroundings;
pub use trajectory::Trajectory;
