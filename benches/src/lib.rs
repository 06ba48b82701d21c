//! Benchmarks across both crates.

pub mod adbench;
pub mod tapes;
