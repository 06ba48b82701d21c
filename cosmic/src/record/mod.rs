//! Runs in folders: the files of a run, and optimising in a folder.
//!
//! [`optimise`] begins a run and [`resume`] continues one; [`optimise_with`] and [`resume_with`]
//! take the caller's loss or robot. The folder holds at any moment all that resuming needs. A run
//! that is killed at any point and resumed ends with the same bytes, except wall times.

pub mod files;
pub mod design_file;
pub mod trajectory_file;
pub mod history;
pub mod snapshot;
pub mod summary;
mod agreement;
pub mod run;
pub mod multistart;
mod carry_out;

pub use agreement::check_one_run;
pub use carry_out::{allow_unstable, deliver_so_far, optimise, optimise_with, resume, resume_with};
pub use design_file::DesignFile;
pub use multistart::MOST_RUNS;
pub use run::{Observer, Run};
pub use snapshot::{RunPlan, Search};
pub use summary::{DIVERGED, Start, StopReason, Summary};
pub use trajectory_file::TrajectoryFile;
