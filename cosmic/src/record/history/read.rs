//! Reading a history.

use super::rows::{FORMAT, HistoryRow, LINES};
use crate::codesign::Record;
use crate::error::Result;
use crate::reading::read_whole;
use crate::record::files::{Format, parse_stamped};
use serde::de::DeserializeOwned;
use std::path::Path;

/// The iterations of a run's `history.jsonl`, from the first on.
///
/// # Errors
/// As [`read_lines`].
pub fn read(folder: &Path) -> Result<Vec<Record>> {
    read_first(folder, usize::MAX)
}

/// The first `iterations` rows, or all if there are fewer. Later rows are not read: a stopped run may
/// end with a part of a line, which resuming removes.
///
/// # Errors
/// As [`read_lines`].
pub(in crate::record) fn read_first(folder: &Path, iterations: usize) -> Result<Vec<Record>> {
    let rows: Vec<HistoryRow> = first_lines(&folder.join(LINES), FORMAT, iterations)?;
    Ok(rows.into_iter().map(|row| row.record).collect())
}

/// The rows of a file of JSON lines, each with its format and version.
///
/// # Errors
/// [`Error::Read`](crate::Error::Read) for a missing file,
/// [`Error::Malformed`](crate::Error::Malformed) for a line of another form.
pub fn read_lines<T: DeserializeOwned>(path: &Path, format: Format) -> Result<Vec<T>> {
    first_lines(path, format, usize::MAX)
}

fn first_lines<T: DeserializeOwned>(path: &Path, format: Format, most: usize) -> Result<Vec<T>> {
    let bytes = read_whole(path)?;
    let lines = bytes.strip_suffix(b"\n").unwrap_or(&bytes);
    let lines = lines.split(|&byte| byte == b'\n');
    let lines = lines.enumerate().take_while(|_| !bytes.is_empty());
    let read = |(index, line): (usize, &[u8])| parse_stamped(path, index, line, format);
    lines.take(most).map(read).collect()
}
