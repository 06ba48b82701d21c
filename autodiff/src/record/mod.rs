//! Generic code recorded as a list of operations.

pub mod emit;
pub(crate) mod trace;
