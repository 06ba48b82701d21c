//! Runs in folders: optimising in a folder, and the files of a run.
//!
//! `optimise` begins a run and `resume` continues it; `optimise_with` and `resume_with` do so with the caller's loss or
//! robot. At any time, the folder holds everything that resuming needs. A run that is killed at any point and resumed
//! ends with the same bytes, except for wall times.
//!
//! All of this needs the feature `files`, except [`DesignFile`], the contents of a design file.

pub mod format;
#[cfg(feature = "files")]
pub mod files;
pub mod design_file;
#[cfg(feature = "files")]
pub mod trajectory_file;
#[cfg(feature = "files")]
pub mod history;
#[cfg(feature = "files")]
pub mod snapshot;
#[cfg(feature = "files")]
pub mod summary;
#[cfg(feature = "files")]
pub mod damaged;
#[cfg(feature = "files")]
pub mod run;
#[cfg(feature = "files")]
pub mod multistart;
#[cfg(feature = "files")]
mod carry_out;

pub use design_file::DesignFile;

#[cfg(feature = "files")]
pub use carry_out::{
    allow_unstable, deliver_so_far, optimise, optimise_with, resume, resume_of, resume_with,
};
#[cfg(feature = "files")]
pub use multistart::MOST_RUNS;
#[cfg(feature = "files")]
pub use run::{Observer, Run};
#[cfg(feature = "files")]
pub use snapshot::RunPlan;
#[cfg(feature = "files")]
pub use summary::DIVERGED;
#[cfg(feature = "files")]
pub use trajectory_file::TrajectoryFile;
