//! Runs in folders: optimising in a folder, and the files of a run.
//!
//! `optimise` begins a run and `resume` continues it; `optimise_with` and `resume_with` do so with the caller's loss or
//! robot. At any time, the folder holds everything that resuming needs. A run that is killed at any point and resumed
//! ends with the same bytes, except for wall times.

pub mod files;
pub mod trajectory_file;
pub mod history;
pub mod snapshot;
pub mod summary;
pub mod damaged;
pub mod run;
mod multistart;
mod carry_out;

pub use carry_out::{
    allow_unstable, deliver_so_far, optimise, optimise_with, resume, resume_of, resume_with,
};
pub use multistart::{MOST_RUNS, folder_of};
pub use run::{Observer, Run};
pub use snapshot::RunPlan;
pub use summary::DIVERGED;
pub use trajectory_file::TrajectoryFile;
