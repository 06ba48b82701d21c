//! Measurements of finished runs: the design in changed scenes ([`check`]) and in MuJoCo ([`walks`]). Each is a file in
//! the run's folder. [`numbers`] returns all numbers of a run by name.

mod check;
mod walks;
mod numbers;

pub(crate) use check::Check;
pub(crate) use numbers::numbers;
pub(crate) use walks::{Walks, check_python};
