//! The objectives of GradBench, and the tool that answers its requests.

pub mod objectives;
pub mod gradbench;
