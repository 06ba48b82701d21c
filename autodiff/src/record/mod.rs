//! Generic code recorded as a list of operations.
//!
//! A `Symbol` is a number that notes how it was made. [`emit`] runs the reverse tape over
//! symbols and prints the adjoint as Rust; a sum over data ([`batch::Sum`](crate::batch::Sum)) records its
//! summand once and replays it for all data; [`AnyProgram`] lets number types other than floats interpret
//! the kernels of code that does not know the number type.

pub(crate) mod operation;
pub(crate) mod arithmetic;
mod known;
pub(crate) mod recording;
pub(crate) mod symbol;
pub mod emit;
mod interpreted;
mod any_program;

pub use any_program::AnyProgram;
