//! Writing of text files.

use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use std::path::{Path, PathBuf};

/// Writes a text to a file, replacing its content.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<()> {
    write_atomic(path, |file| file.write_all(text.as_bytes()))
}

/// Writes a list of texts, each with its file name, into a folder, and returns the paths.
pub(crate) fn write_texts<N: AsRef<Path>>(
    folder: &Path,
    texts: impl IntoIterator<Item = (N, String)>,
) -> Result<Vec<PathBuf>> {
    let write = |(name, text): (N, String)| {
        let path = folder.join(name);
        write_text(&path, &text)?;
        Ok(path)
    };
    texts.into_iter().map(write).collect()
}
