//! Reverse mode: a [`Tape`] that records, [`Var`]s that are recorded, a sweep that pulls
//! cotangents back.

mod current;
mod fused;
mod spare;
mod tape;
mod var;

pub(crate) use spare::with_tape;
pub use tape::Tape;
pub use var::Var;
