//! Reading a history.

use super::rows::{FORMAT, HistoryRow, LINES};
use crate::codesign::Record;
use crate::error::Result;
use crate::reading::read_whole;
use crate::record::format::{Format, parse_stamped};
use serde::de::DeserializeOwned;
use std::path::Path;

/// The first iterations of a run's `history.jsonl`, at most so many. Later rows are not read: a stopped
/// run may end with a part of a line, which resuming removes.
///
/// # Errors
/// As [`read_lines`].
pub fn read(folder: &Path, most: usize) -> Result<Vec<Record>> {
    let rows: Vec<HistoryRow> = read_lines(&folder.join(LINES), FORMAT, most)?;
    Ok(rows.into_iter().map(|row| row.record).collect())
}

/// The first rows of a file of JSON lines, at most so many, each with its format and version.
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
