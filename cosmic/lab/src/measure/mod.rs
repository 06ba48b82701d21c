//! Measurements of finished runs, with a file in the run's folder for each: the design in changed scenes, and in
//! MuJoCo. [`numbers`] returns all numbers of a run by name.

mod check;
mod walks;
mod numbers;

pub(crate) use check::Check;
pub(crate) use numbers::numbers;
pub(crate) use walks::{Walks, check_python};
