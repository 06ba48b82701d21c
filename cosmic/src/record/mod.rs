//! What a run leaves on disk.

pub mod design_file;
pub mod files;

pub use design_file::DesignFile;
