//! Multi-start search: every seed is a run in `starts/SEED`, and the best run is the result.

mod starts;
mod search;

pub use search::MOST_RUNS;
pub(super) use search::{create, search};
pub(super) use starts::begun;
pub use starts::folder_of;
