//! Settings of what goes beyond the paper, all of it off by default: a search over starts that
//! drops the weak ones early.

use serde::Serialize;

/// How `optimize --starts N --search halving` drops weak starts; not read otherwise.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SearchSettings {
    /// Iterations after which starts are dropped, ascending; those from the last one on are none.
    pub rungs: [usize; 3],
    /// Share of the starts that goes on after each of them, rounded up.
    pub keep: [f64; 3],
    /// Iterations up to a rung over which a start's displacement is judged, by their median.
    pub window: usize,
}

impl Default for SearchSettings {
    fn default() -> Self {
        Self {
            rungs: [60, 200, 260],
            keep: [0.34, 0.5, 0.5],
            window: 10,
        }
    }
}
