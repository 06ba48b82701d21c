//! The rows of `history.jsonl` and of `designs.jsonl`.

use super::walk::Walk;
use crate::codesign::Record;
use crate::record::format::Format;
use serde::{Deserialize, Serialize};

/// The format of every line of `history.jsonl`.
pub const FORMAT: Format = Format::new("cosmic-history", 1);

/// The history as JSON lines.
pub const LINES: &str = "history.jsonl";
/// The history as a table.
pub const TABLE: &str = "history.csv";

/// The format of every line of `designs.jsonl`.
pub const DESIGNS_FORMAT: Format = Format::new("cosmic-designs", 1);
/// The design vectors of some iterations, as JSON lines.
pub const DESIGNS: &str = "designs.jsonl";

/// Iterations from one line of `designs.jsonl` to the next; the first iteration has one too.
const DESIGNS_EVERY: usize = 10;

/// A line of `designs.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignRow {
    /// The iteration that produced the design.
    pub iteration: usize,
    /// Design vectors, one per edge, to four decimals: enough for pictures, too few to resume from.
    pub z: Vec<[f64; 3]>,
    /// How the robot walks with the controller of that iteration; `None` if the rollout diverged, and in
    /// files of earlier versions.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub walk: Option<Walk>,
}

impl DesignRow {
    /// The row of an iteration.
    pub(in crate::record) fn new(iteration: usize, z: &[[f64; 3]], walk: Option<Walk>) -> Self {
        let rounded = |x: f64| (1e4 * x).round() / 1e4;
        let z = z.iter().map(|z| z.map(rounded)).collect();
        Self { iteration, z, walk }
    }
}

/// Number of lines of `designs.jsonl` up to an iteration, in a run that entered after `entered`.
pub(super) fn design_rows(entered: usize, iteration: usize) -> usize {
    let tens = iteration / DESIGNS_EVERY - entered / DESIGNS_EVERY;
    let first = entered + 1;
    tens + usize::from(iteration >= first && !first.is_multiple_of(DESIGNS_EVERY))
}

/// A line of `history.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HistoryRow {
    /// The iteration.
    #[serde(flatten)]
    pub record: Record,
    /// Wall time of the run so far without interruptions, s.
    pub seconds: f64,
}
