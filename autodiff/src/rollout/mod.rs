//! Rollouts: stepping a [`Program`](crate::Program) many times, and the reverse sweep through all of it.
//!
//! The forward run keeps the row of every step: its state and the outputs of its operations. The
//! reverse sweep goes back one step at a time and recomputes what happens inside operations. Memory:
//! `steps` rows, or what a [`Memory`] budget allows.

mod checkpoints;
mod cotangent_bound;
mod settings;
mod progress;
mod sweep;
mod single;
mod batched;
#[cfg(test)]
mod tests;

pub use checkpoints::Memory;
pub use cotangent_bound::CotangentBound;
pub(crate) use progress::step;
pub use settings::{Given, Model, Rollout};
