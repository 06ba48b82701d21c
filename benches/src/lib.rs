//! Benchmarks across both crates.

pub mod adbench;
pub mod callgrind;
#[cfg(test)]
mod emitted;
pub mod handwritten;
pub mod machine;
pub mod tapes;
