//! Benchmarks across both crates.

pub mod machine;
pub mod adbench;
pub mod callgrind;
pub mod gradbench;
pub mod handwritten;
pub mod tapes;
