//! Programs over arrays: what one step of a simulation computes, recorded once and run many
//! times, forward and in reverse.
//!
//! A step is written once as a generic function over `R: Real` that calls the methods of
//! [`Program`]. For plain floats every operation runs in SIMD lanes; for duals, extended
//! precision or tape variables the same operations run on those numbers. There is no control
//! flow inside a program: kernels select, and what a model does not need is not recorded.
//!
//! All arrays of a step but the parameters lie one after the other in its **row**. If the state comes
//! first, the row of the next step begins where this one puts its new state, so that a rollout that
//! keeps its rows copies nothing: they are the record from which the reverse sweep works.
//!
//! A program may run from several **starts** at once: from two, or from a register's lanes of them.
//! Their numbers are interleaved: every number of a row stands there once for each start, so that an
//! array is that many times as long, and a graph is that many graphs interleaved. Operations treat the
//! longer arrays like any others; only products with matrices, which all starts share, are different.
//! Parameters other than matrices may differ from start to start.

mod kernel;
mod array;
mod graph;
mod row;
mod operation;
pub(crate) mod dense;
mod map;
mod edges;
mod gather;
mod weighted;
mod program;
mod recording;
mod run;
mod watch;

pub use array::{Array, Matrix};
pub(crate) use dense::Aligned;
pub use graph::Graph;
pub(crate) use graph::SlotEdge;
pub use kernel::{Kernel, Pullback, vjp_by_duals};
pub(crate) use operation::Operation;
pub use program::Program;
pub(crate) use row::{Bars, StepValues};
pub(crate) use watch::Watch;
