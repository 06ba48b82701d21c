//! The rows of `history.jsonl` and of `designs.jsonl`.

use crate::codesign::Record;
use crate::record::files::Format;
use serde::{Deserialize, Serialize};

/// What every line of `history.jsonl` says it is.
pub const FORMAT: Format = Format {
    name: "cosmic-history",
    version: 1,
};

/// The history as JSON lines.
pub const LINES: &str = "history.jsonl";
/// The history as a table.
pub const TABLE: &str = "history.csv";

/// What every line of `designs.jsonl` says it is.
pub const DESIGNS_FORMAT: Format = Format {
    name: "cosmic-designs",
    version: 1,
};
/// The design vectors on the way, as JSON lines.
pub const DESIGNS: &str = "designs.jsonl";

/// Iterations from one line of `designs.jsonl` to the next; the first iteration has one too.
const DESIGNS_EVERY: usize = 10;

/// A line of `designs.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignRow {
    /// The name in [`DESIGNS_FORMAT`].
    pub format: String,
    /// The version in [`DESIGNS_FORMAT`].
    pub version: u32,
    /// The iteration after which the design stood.
    pub iteration: usize,
    /// Design vectors, one per edge, to four decimals: to be looked at, not to go on from.
    pub z: Vec<[f64; 3]>,
}

/// Lines of `designs.jsonl` up to an iteration, in a run that enters after another.
pub(super) fn design_rows(entered: usize, iteration: usize) -> usize {
    let tens = iteration / DESIGNS_EVERY - entered / DESIGNS_EVERY;
    let first = entered + 1;
    tens + usize::from(iteration >= first && !first.is_multiple_of(DESIGNS_EVERY))
}

/// A line of `history.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HistoryRow {
    /// The name in [`FORMAT`].
    pub format: String,
    /// The version in [`FORMAT`].
    pub version: u32,
    /// The iteration.
    #[serde(flatten)]
    pub record: Record,
    /// Wall time since the run began, interruptions left out, s.
    pub seconds: f64,
}
