//! Many runs from one frozen plan.
//!
//! The folder of a sweep holds `plan.json`, written once, and below `runs` an ordinary run folder for
//! every scene and seed. Any number of processes may work on it at once. A process holds a lock on the
//! claim of its run; the system releases the lock when the process ends, however it ends. The files of
//! the runs alone say what is done, so a sweep continues wherever it was interrupted. [`merge`] reads
//! records and simulates nothing.

mod state;
mod plan;
mod claim;
mod merge;
mod work;

pub use merge::{MergedRun, SweepResults, merge, survey, write_results};
pub use plan::{PLAN, PlannedScene, SweepPlan};
pub use state::RunState;
pub use work::{Ended, Overseer, RunOutcome, Sweep};
