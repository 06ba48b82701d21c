//! The lines of `history.jsonl` and `designs.jsonl`.

use super::frames::Frames;
use crate::error::Result;
use crate::format::{Format, parse_stamped};
use crate::reading::read_whole;
use crate::search::Record;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The format of every line of `history.jsonl`.
pub(super) const FORMAT: Format = Format::new("cosmic-history", 1);

/// The name of the file with the history as JSON lines.
pub const LINES: &str = "history.jsonl";

/// The format of every line of `designs.jsonl`.
pub const DESIGNS_FORMAT: Format = Format::new("cosmic-designs", 1);
/// The name of the file with the designs of some iterations, as JSON lines.
pub const DESIGNS: &str = "designs.jsonl";

/// `designs.jsonl` has a line for the first iteration, and for every iteration whose number is a multiple of this one.
const DESIGNS_EVERY: usize = 10;

/// A line of `designs.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DesignRow {
    /// The iteration that produced the design.
    pub iteration: usize,
    /// Design vectors, one per edge, to four decimals. That is enough for pictures but not for resuming.
    pub z: Vec<[f64; 3]>,
    /// The motion of the robot with the controller of the iteration. `None` if the rollout diverged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walk: Option<Frames>,
}

impl DesignRow {
    /// Makes the row of an iteration; `z` is rounded.
    pub fn new(iteration: usize, z: &[[f64; 3]], walk: Option<Frames>) -> Self {
        let rounded = |x: f64| (1e4 * x).round() / 1e4;
        let z = z.iter().map(|z| z.map(rounded)).collect();
        Self { iteration, z, walk }
    }
}

/// The number of lines that `designs.jsonl` has after an iteration. The first iteration of the run is `entered + 1`.
pub(super) fn design_rows(entered: usize, iteration: usize) -> usize {
    let tens = iteration / DESIGNS_EVERY - entered / DESIGNS_EVERY;
    let first = entered + 1;
    tens + usize::from(iteration >= first && !first.is_multiple_of(DESIGNS_EVERY))
}

/// A line of `history.jsonl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct HistoryRow {
    /// The record of the iteration.
    #[serde(flatten)]
    pub record: Record,
    /// Wall time of the run so far without interruptions, in seconds.
    pub seconds: f64,
}

/// Reads at most `most` iterations from the beginning of a run's `history.jsonl`. Later lines are not read, because a
/// killed run may leave an unfinished line at the end, which is removed when the run is resumed.
///
/// # Errors
/// The errors of [`read_lines`].
pub fn read(folder: &Path, most: usize) -> Result<Vec<Record>> {
    let rows: Vec<HistoryRow> = read_lines(&folder.join(LINES), FORMAT, most)?;
    Ok(rows.into_iter().map(|row| row.record).collect())
}

/// Reads at most `most` lines from the beginning of a file of JSON lines. Each line must begin with `format` and
/// `version`.
///
/// # Errors
/// [`Error::Read`](crate::Error::Read) for a missing file,
/// [`Error::Malformed`](crate::Error::Malformed) for a line of another form.
pub fn read_lines<T: DeserializeOwned>(path: &Path, format: Format, most: usize) -> Result<Vec<T>> {
    let bytes = read_whole(path)?;
    let lines = bytes.strip_suffix(b"\n").unwrap_or(&bytes);
    let lines = lines.split(|&byte| byte == b'\n');
    let lines = lines.enumerate().take_while(|_| !bytes.is_empty());
    let read = |(index, line): (usize, &[u8])| parse_stamped(path, index, line, format);
    lines.take(most).map(read).collect()
}
