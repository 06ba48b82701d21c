//! Measurements of finished runs: `check` simulates the design in changed scenes, [`Errands`] on its way to unseen goals,
//! and [`Walks`] in MuJoCo. Each measurement is a file in the run's folder. `numbers` returns all numbers of a run by name.

mod check;
mod errands;
mod walks;
mod numbers;

pub(crate) use check::Check;
pub(crate) use errands::{Disturbed, Measured, quantile_of};
pub use errands::{Errand, Errands, Loops};
pub(crate) use numbers::numbers;
pub use walks::Walks;
pub(crate) use walks::check_python;
