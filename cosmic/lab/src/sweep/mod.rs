//! Sweeps: many runs from one frozen plan.
//!
//! The folder of a sweep holds `plan.json`, which is written once, and the folder `runs` with an ordinary run folder
//! for every scene and seed. Any number of processes on any number of hosts may work on the sweep at once. A process
//! claims a run before it works on it. When the process ends, even by a crash, other processes can claim the run. Only
//! the files of the runs tell which runs are done, so an interrupted sweep continues where it stopped. [`merge`]
//! collects the results and does not simulate.

mod ranges;
mod state;
mod plan;
mod grid;
mod frozen;
pub mod claim;
mod merge;
mod prune;
mod work;
mod script;

pub use grid::{Combination, GridAxis, combinations, on_grid};
pub use merge::{Merged, Survey, SurveyedRun, merge, survey};
pub use plan::{PLAN, PlannedScene, PlannedStudy, SweepPlan, SweptValue};
pub use prune::{Pruned, prune};
pub use ranges::{in_ranges, parse_ranges};
pub use script::{HandOver, Scheduler};
pub use state::{RunState, iterations};
pub use work::{Ended, Overseer, RunOutcome, Sweep};
