//! Steps and rollouts. A [`Program`] is the recording of one step of a simulation. A [`Rollout`] runs it many times,
//! forward and in reverse.
//!
//! A step is a list of operations on arrays, which a model records by the methods of [`Program`]. It has no control flow:
//! kernels select between values, and a model records only the operations that it needs.
//!
//! A program can run from several **starts** (initial states) at once: from two, or from one for each lane of a
//! register. Pairs have their own code path, because a start often comes with its mirror image. For a net of 36 nodes that a
//! network drives, the two gradients of a pair would take 1.2 times as long one after the other.
//!
//! The numbers of the starts are interleaved, so arrays and graphs become two (or `lanes`) times as long. Most operations
//! treat a longer array like any other. Only matrix products differ, because all starts share the matrices. Other parameters
//! may differ between starts.

mod checks;
mod mapped;
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
mod added;
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
mod operation;
pub(crate) mod program;
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
mod parts;
mod recording;
mod on_graphs;
pub(crate) mod instance;
mod watch;
mod checkpoints;
mod cotangent_bound;
mod settings;
mod sweep;
mod interleaved;
mod batched;
#[cfg(test)]
mod tests;

pub use added::AddedOperation;
pub use checkpoints::Memory;
pub use cotangent_bound::CotangentBound;
pub use operation::StepOperation;
pub use parts::Parts;
pub use program::Program;
pub use settings::{Given, Model, Rollout};
pub use settings::{check_bounds, check_units};
