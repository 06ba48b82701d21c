//! Measurements of finished runs: `check` simulates the design in changed scenes, and [`Walks`] in MuJoCo. Each
//! measurement is a file in the run's folder. `numbers` returns all numbers of a run by name.

mod check;
mod walks;
mod numbers;

pub(crate) use check::Check;
pub(crate) use numbers::numbers;
pub use walks::Walks;
pub(crate) use walks::check_python;
