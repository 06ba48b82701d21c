//! Many runs from one frozen plan.
//!
//! A sweep's folder has `plan.json`, written once, and below `runs` an ordinary run's folder for
//! every scene and seed. Any number of processes may work on it at once: whoever takes a run holds
//! a lock on its claim, which the system gives back when that process ends, however it ends. What
//! is done is told by the runs' own files alone, so that a sweep goes on wherever it was
//! interrupted, and [`merge`] reads records and simulates nothing.

mod state;
mod plan;
mod claim;
mod merge;
mod work;

pub use merge::{MergedRun, SweepResults, merge, survey, write_results};
pub use plan::{PLAN, PlannedScene, SweepPlan};
pub use state::RunState;
pub use work::{Ended, Overseer, RunOutcome, Sweep};
