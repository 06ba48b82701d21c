//! What a robot is worth: how far it walks, how surely, how its bars are loaded, and in plain words whether it could be built.
//!
//! An [`Evaluator`] simulates robots of one scene. It ranks them while a [search](crate::search) goes on. At the end the search
//! hands over its controllers; one of them is chosen, and the robot is measured: the result is a [`Delivery`]. A [`verdict`]
//! judges it.

mod quantiles;
mod measurements;
mod standstill;
mod evaluator;
mod other_steps;
mod reliability;
mod reach;
mod variations;
mod observed;
mod sensitivity;
mod ways;
mod low_friction;
mod delivery;
pub mod verdict;

pub(crate) use delivery::Entrants;
pub use delivery::{Candidate, Delivery};
pub use evaluator::Evaluator;
pub use low_friction::LOW_FRICTION;
pub use measurements::{Measurements, Measuring};
pub use observed::ObservedRollout;
pub use other_steps::{Medians, OtherSteps};
pub use quantiles::Quantiles;
pub(crate) use reach::robots_of;
pub use reach::{Reached, first_best};
pub use reliability::{LEAST_MEDIAN, Merit, Reliability, STEADY};
pub use sensitivity::Sensitivity;
pub use standstill::Standstill;
pub use variations::VARIED;
pub(crate) use variations::with_goals;
pub use ways::Way;
