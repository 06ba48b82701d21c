//! Steps and rollouts: what one step of a simulation computes is recorded once as a [`Program`], and a
//! [`Rollout`] runs it many times, forward and in reverse.
//!
//! A step is written once as a generic function over `R: Real` that calls the methods of [`Program`]. There is
//! no control flow inside a program: kernels select, and what a model does not need is not recorded.
//!
//! All arrays of a step but the parameters lie one after the other in its **row**. If the state comes
//! first, the row of the next step begins where this one puts its new state, so that a rollout that
//! keeps its rows copies nothing: they are the record from which the reverse sweep works. The sweep goes back
//! one step at a time and recomputes what happens inside operations. Memory: `steps` rows, or what a
//! [`Memory`] budget allows.
//!
//! A program may run from several **starts** at once: from two, or from a register's lanes of them.
//! Their numbers are interleaved: every number of a row stands there once for each start, so that an
//! array is that many times as long, and a graph is that many graphs interleaved. Operations treat the
//! longer arrays like any others; only products with matrices, which all starts share, are different.
//! Parameters other than matrices may differ from start to start.

mod program;
mod recording;
mod run;
mod watch;
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
pub use program::Program;
pub(crate) use progress::step;
pub use settings::{Given, Model, Rollout};
