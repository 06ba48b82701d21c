//! Many runs from one frozen plan.
//!
//! The folder of a sweep holds `plan.json`, written once, and below `runs` an ordinary run folder for
//! every scene and seed. Any number of processes may work on it at once, on any number of hosts that see the
//! folder. A process claims its run, and gives it back when it ends, however it ends. The files of the runs
//! alone say what is done, so a sweep continues wherever it was interrupted. [`merge`] reads
//! records and simulates nothing.

mod ranges;
mod state;
mod plan;
mod grid;
mod frozen;
mod claim;
mod merge;
mod prune;
mod work;
mod script;

pub use grid::on_grid;
pub use merge::{Merged, Survey, SurveyedRun, merge, survey};
pub use plan::{
    HasScene, PLAN, PlanOutline, PlannedScene, PlannedStudy, SweepPlan, SweptValue, UnreadPlan,
};
pub use prune::{Pruned, prune};
pub use ranges::{in_ranges, parse_ranges};
pub use script::{HandOver, Scheduler};
pub use state::RunState;
pub use work::{Ended, Overseer, RunOutcome, Sweep};
