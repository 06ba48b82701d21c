//! Measurements of finished runs, each a file in the run's folder: the design in changed scenes, and in MuJoCo.
//! [`numbers`] has all numbers of a run by name.

mod check;
mod walks;
mod numbers;

pub(crate) use check::Check;
pub(crate) use numbers::numbers;
pub(crate) use walks::{Walks, check_python};
