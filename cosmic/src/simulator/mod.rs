//! The simulator: computes a trajectory from a body, a controller and an initial state.
//!
//! The physics is in [`laws`](crate::laws). The modules `robot` and `mechanics` combine the laws to a step, which is
//! written once for all number types. A rollout computes in the ground's frame: there, a node is below flat ground if
//! its second coordinate is negative. Callers pass and get states in the world's frame.

mod surroundings;
mod parameters;
mod effort;
mod implicit;
mod mechanics;
mod robot;
mod energy;
pub mod stability;
mod step_check;
mod trajectory;
mod prepare;
mod plan;
mod rollout;
#[cfg(feature = "wgsl")]
mod printed;
mod blame;
mod divergence;
mod magnitude;
mod loads;
mod economy;

pub use blame::Cause;
pub use divergence::{Divergence, GuardedRollout};
pub use economy::Energy;
pub use effort::{Effort, Efforts};
pub use energy::IdleEnergy;
pub use loads::{BarLoad, EdgeMoments, Loads};
pub use magnitude::{Largest, Magnitude};
pub use plan::Robots;
pub use prepare::{Simulator, Span};
#[cfg(feature = "wgsl")]
pub use printed::{PrintedRobots, Wanted, Workgroup};
pub use step_check::{Grade, StepCheck, StepLimit, rounded_down};
pub use surroundings::Surroundings;
pub use trajectory::{PayloadState, Trajectory};
