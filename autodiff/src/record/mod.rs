//! Generic code recorded as a list of operations.
//!
//! A `Symbol` is a number that notes how it was made. [`emit`] runs the reverse tape over
//! symbols and prints the adjoint as Rust. All else replays a recording: a sum or a map over data (`data`), and number
//! types other than floats in an [`AnyProgram`].

pub(crate) mod operation;
pub(crate) mod arithmetic;
mod known;
pub(crate) mod recording;
pub(crate) mod symbol;
pub mod emit;
pub(crate) mod replay;
mod replayed;
mod any_program;

pub use any_program::AnyProgram;
