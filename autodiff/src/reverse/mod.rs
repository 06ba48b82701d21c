//! Reverse mode: a [`Tape`] records operations on [`Var`]s, and a sweep pulls cotangents back to the inputs.

mod index;
mod fused_entry;
mod entries;
mod careful;
mod arena;
mod current;
mod var;
mod fused;
mod arithmetic;
mod dependence;
mod tape;
mod pool;

pub(crate) use pool::{keep_tape, recorded};
pub use tape::Tape;
pub use var::Var;
