//! Benchmarks across both crates.

pub mod machine;
pub mod adbench;
pub mod callgrind;
pub mod handwritten;
pub mod tapes;
