//! Benchmarks across both crates.

pub mod machine;
pub mod distance;
pub mod objectives;
pub mod adbench;
pub mod gradbench;
pub mod driver;
