//! Benchmarks across both crates.

pub mod adbench;
pub mod callgrind;
pub mod tapes;
