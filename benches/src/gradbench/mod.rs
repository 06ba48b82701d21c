//! GradBench's protocol (<https://github.com/gradbench/gradbench>).

pub mod draw;
pub mod protocol;
