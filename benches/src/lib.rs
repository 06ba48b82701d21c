//! Benchmarks of the project's crates.

pub mod machine;
pub mod robot;
pub mod objectives;
pub mod gradbench;
