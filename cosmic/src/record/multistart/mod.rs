//! Multi-start search: every seed is a run in `starts/SEED`, and the best run is the result. Either all runs are
//! finished, or successive halving drops weak ones early.

mod starts;
mod halving;
mod search;

pub use halving::{FORMAT, Halving, Rung, SEARCH, Standing, median};
pub use search::MOST_RUNS;
pub(super) use search::{create, search};
pub(super) use starts::begun;
pub use starts::folder_of;
