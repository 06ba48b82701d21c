//! Benchmarks across both crates.

pub mod adbench;
