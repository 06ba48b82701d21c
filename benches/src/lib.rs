//! Benchmarks across both crates.

pub mod adbench;
#[cfg(test)]
mod emitted;
pub mod tapes;
