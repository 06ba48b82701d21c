//! What an optimisation ends with, as the contents of files. [`record`](crate::record) writes the files.

mod summary;

pub use summary::{Start, StopReason, Summary, ratio};
