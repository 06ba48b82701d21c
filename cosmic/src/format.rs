//! The keys `format` and `version`, which every JSON file begins with.

use crate::error::Result;
use crate::reading::{Position, from_json, malformed};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The first two keys of a JSON file, `format` and `version`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Format {
    /// The kind of file, such as `cosmic-design`.
    #[serde(rename = "format")]
    pub name: &'static str,
    /// The version, which is raised by every change that older programs would misread.
    pub version: u32,
}

/// The keys of a JSON file: `format` and `version`, then the keys of the body.
#[derive(Serialize)]
pub(crate) struct Stamped<'b, T> {
    #[serde(flatten)]
    pub(crate) format: Format,
    #[serde(flatten)]
    pub(crate) body: &'b T,
}

impl Format {
    /// A format with the given kind of file and the given version.
    pub const fn new(name: &'static str, version: u32) -> Self {
        Self { name, version }
    }

    /// One line of JSON with the keys `format` and `version` and the keys of the body.
    pub(crate) fn line<T: Serialize>(self, body: &T) -> String {
        let text = serde_json::to_string(&Stamped { format: self, body });
        text.expect("numbers with string keys can be written as JSON") + "\n"
    }
}

/// The keys `format` and `version` of a file that is being read.
#[derive(Deserialize)]
struct Stamp {
    format: String,
    version: u32,
}

/// Parses a JSON file that begins with `format` and `version`; errors name `path`. `T` must accept these two keys.
///
/// # Errors
/// [`Error::Malformed`](crate::Error::Malformed) for bytes that are not JSON, have another format or version, or lack
/// keys.
pub(crate) fn parse_json<T: DeserializeOwned>(
    path: &Path,
    bytes: &[u8],
    format: Format,
) -> Result<T> {
    parse_stamped(path, 0, bytes, format)
}

/// Like [`parse_json`], for the part of a file that begins after `lines` lines. Errors name the line within the whole
/// file.
pub(crate) fn parse_stamped<T: DeserializeOwned>(
    path: &Path,
    lines: usize,
    bytes: &[u8],
    format: Format,
) -> Result<T> {
    let file = &path.display().to_string();
    let stamp: Stamp = from_json(file, lines, bytes)?;
    if stamp.format != format.name || stamp.version != format.version {
        let message = format!(
            "the format is {:?} version {}, not {:?} version {}",
            stamp.format, stamp.version, format.name, format.version
        );
        let (line, column) = (lines + 1, 1);
        return Err(malformed(file, Position { line, column }, &message));
    }
    from_json(file, lines, bytes)
}
