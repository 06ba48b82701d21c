//! Reverse mode: a [`Tape`] that records, [`Var`]s that are recorded, a sweep that pulls
//! cotangents back.

mod current;
mod fused;
mod tape;
mod var;

pub use tape::Tape;
pub use var::Var;
