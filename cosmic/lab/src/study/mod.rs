//! Studies: a TOML file describes experiments; each is repeated with many seeds and compared with published numbers.
//!
//! A [`Study`] is a sweep with tables. [`prepare`](Study::prepare) freezes its plan,
//! [`simulate`](Study::simulate) completes and measures the runs, and [`write`](Study::write) reads their
//! records. The plan determines all numbers except wall times.

mod file;
mod tables;
mod work;
mod results;

pub use file::{Base, StudyFile};
pub use work::Study;
