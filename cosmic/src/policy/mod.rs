//! Policies. A policy computes one activation per edge from the state of a robot and the time.
//!
//! A [`Policy`] declares its parameters, which are named blocks of one flat vector (a [`Controller`]). It also records
//! how a step computes the activations from them. [`Mlp`] is the paper's network. [`Clock`] is the same network in open
//! loop: it does not observe the robot.

mod block;
mod sensing;
mod gaits;
mod goals;
mod image;
mod tempo;
mod fold;
mod weighted;
mod source;
mod step;
mod mlp;
mod clock;
mod saved;
mod choice;

pub use block::{Block, Controller, NETWORK, Role, Shape};
pub use choice::{blocks_of, of_settings};
pub use clock::Clock;
pub use fold::{Fold, Mean};
pub use gaits::Gaits;
pub use goals::Goals;
pub(crate) use goals::{Hold, Pick};
pub use mlp::{Layer, Mlp, Network};
pub use saved::Weights;
pub use sensing::{Sight, clock, observation};
pub(crate) use source::{BlockSource, Outputs};
pub(crate) use step::Seen;
pub use step::{Policy, PolicyStep, Sizes};
pub use tempo::{TEMPO, frequency};
pub(crate) use tempo::{Turn, ahead, ticks};
#[doc(hidden)] // For the printer of `cosmic-gpu`.
pub use weighted::Weighted;
pub(crate) use weighted::weighted;
