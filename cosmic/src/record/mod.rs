//! What a run leaves on disk, and running in a folder.
//!
//! [`optimise`] begins a run and [`resume`] goes on with one; [`optimise_with`] and
//! [`resume_with`] have a loss or a beginning of one's own. A run's folder holds at any moment
//! what going on needs: killed anywhere and resumed, a run ends with the bytes it would have
//! ended with, wall times aside.

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
pub use carry_out::{allow_unstable, optimise, optimise_with, resume, resume_with};
pub use design_file::DesignFile;
pub use multistart::MOST_RUNS;
pub use run::{Observer, Run};
pub use snapshot::{RunPlan, Search};
pub use summary::{DIVERGED, Start, StopReason, Summary};
pub use trajectory_file::TrajectoryFile;
