//! Benchmarks of the project's crates.

pub mod machine;
pub mod robot;
pub mod distance;
pub mod objectives;
pub mod adbench;
pub mod gradbench;
pub mod driver;
