//! Reverse mode: a [`Tape`] that records, [`Var`]s that are recorded, a sweep that pulls
//! cotangents back.

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

pub(crate) use pool::with_tape;
pub use tape::Tape;
pub use var::Var;
