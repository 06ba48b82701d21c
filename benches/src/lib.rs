//! Benchmarks across both crates.

#[cfg(test)]
mod emitted;
pub mod machine;
pub mod adbench;
pub mod callgrind;
pub mod handwritten;
pub mod tapes;
