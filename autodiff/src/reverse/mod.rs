//! Reverse mode: a [`Tape`] that records, [`Var`]s that are recorded, a sweep that pulls
//! cotangents back.

mod current;
mod fused;
mod pool;
mod tape;
mod var;

pub(crate) use pool::with_tape;
pub use tape::Tape;
pub use var::Var;
