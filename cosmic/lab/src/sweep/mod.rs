//! Sweeps: a run for every combination of scenes, settings and seeds.
//!
//! The folder of a sweep holds `sweep.json`, its [`Plan`], and the folder `runs` with an ordinary run folder for every
//! run. Only the files of the runs tell which runs are done, so an interrupted sweep continues where it stopped. The
//! folder of a run is locked while a process works in it, so any number of processes may work on a sweep at once: each
//! skips the runs of the others. [`merge`] collects the results and does not simulate.

mod grid;
mod plan;
mod spec;
mod work;
mod merge;

pub use grid::{Axis, Combination, combinations};
pub use merge::{Merged, merge};
pub use plan::{Plan, SWEEP, Trial};
pub use spec::{Overrides, read};
pub use work::{Ended, RunOutcome, Sweep, SweepObserver};
