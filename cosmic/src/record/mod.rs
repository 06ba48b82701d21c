//! What a run leaves on disk, and running in a folder.
//!
//! [`optimise`] begins a run and [`resume`] goes on with one; [`optimise_with`] and
//! [`resume_with`] have a loss or a beginning of one's own. A run's folder holds at any moment
//! what going on needs: killed anywhere and resumed, a run ends with the bytes it would have
//! ended with, wall times aside.

mod allow;
pub mod design_file;
pub mod files;
mod folder;
pub mod halving;
pub mod history;
pub mod run;
pub mod snapshot;
mod starts;
pub mod summary;
pub mod trajectory_file;

pub use allow::allow_unstable;
pub use design_file::DesignFile;
pub use run::{DIVERGED, Observer, Run, optimise, optimise_with, resume, resume_with};
pub use snapshot::{Plan, Search};
pub use starts::MOST_RUNS;
pub use summary::{Start, StopReason, Summary};
pub use trajectory_file::TrajectoryFile;
