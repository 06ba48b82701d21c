//! The simulator. A [`World`] is built once from a scene. [`World::run`] lets [`Robot`]s walk over a [`Span`] of steps and
//! returns a [`Trajectory`] of each.
//!
//! The physics is in [`laws`](crate::laws). The modules `step` and `mechanics` combine the laws to a step, which is
//! written once for all number types. A walk computes in the ground's frame: there, a node is below flat ground if
//! its height is negative. Callers pass and get states in the world's frame.

mod surroundings;
mod parameters;
mod effort;
mod implicit;
mod mechanics;
mod step;
pub mod stability;
mod step_check;
mod trajectory;
mod span;
mod robot;
mod base;
mod draws;
mod plan;
mod run;
mod recorded;

pub(crate) use base::{KEEP_EVERY, kept_steps};
pub use base::{World, together};
pub use draws::{draw, draw_goals, perturbed};
pub(crate) use draws::{draw_goal, draw_many, from_payload};
pub use effort::{Effort, Efforts};
pub use recorded::{RecordedRobots, Source};
pub use robot::{Robot, Variation};
pub use span::Span;
pub use step_check::{Grade, StepCheck, StepLimit, rounded_down};
pub use surroundings::Surroundings;
pub use trajectory::{PayloadState, Trajectory};
