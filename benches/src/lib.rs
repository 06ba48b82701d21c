//! Benchmarks across both crates.

pub mod machine;
pub mod callgrind;
pub mod distance;
pub mod objectives;
pub mod adbench;
pub mod gradbench;
pub mod driver;
pub mod tapes;
