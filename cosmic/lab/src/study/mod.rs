//! Studies: the experiments that a data file describes, many seeds of each, beside published numbers.
//!
//! A [`Study`] is a sweep with tables. [`prepare`](Study::prepare) freezes its plan,
//! [`simulate`](Study::simulate) completes and measures the runs, and [`write`](Study::write) reads their
//! records. All numbers except wall times follow from the plan.

mod file;
mod tables;
mod work;
mod results;

pub use file::{Base, StudyFile};
pub use work::Study;
