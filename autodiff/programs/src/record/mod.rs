//! Records generic code as a list of operations.
//!
//! A `Symbol` is a number that records how it was computed. [`emit`] runs the reverse tape over symbols and prints the
//! adjoint as Rust code. All other users replay a recording: sums and maps over data (`data`), and the kernels of a
//! [`Program`](crate::Program) that runs with numbers which are not floats. A replay computes the recorded operations at
//! many **points** at once. A point is one set of values of the inputs. In addition, there are shared arguments, which
//! are the same at all points.

#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
pub(crate) mod operation;
pub(crate) mod arithmetic;
mod known;
mod computed;
pub(crate) mod recording;
pub(crate) mod symbol;
pub mod emit;
pub(crate) mod replay;
#[allow(missing_docs)] // Only `cosmic-gpu` reads it.
mod replayed;
mod formula;
mod with_uniforms;

pub use formula::Formula;
pub(crate) use replayed::recorded;
pub use replayed::{Places, ReplayedKernel};
pub(crate) use with_uniforms::WithUniforms;
