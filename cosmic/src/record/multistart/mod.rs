//! Several starts: every seed is a run in `starts/SEED`, and the best of them is the result. All
//! are carried out whole, or those that successive halving leaves over.

mod starts;
mod halving;
mod search;

pub use halving::{FORMAT, Halving, Rung, SEARCH, Standing};
pub use search::MOST_RUNS;
pub(super) use search::{create, search};
