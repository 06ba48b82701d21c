//! What an optimisation ends with, as the contents of files. [`record`](crate::record) writes the files.

mod design_file;
mod summary;

pub use design_file::DesignFile;
pub use summary::{Start, StopReason, Summary, ratio};
