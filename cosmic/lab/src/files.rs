//! Files of text.

use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use std::path::{Path, PathBuf};

/// Writes a text to a file, replacing its content.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<()> {
    write_atomic(path, |file| file.write_all(text.as_bytes()))
}

/// Writes texts to files of a folder, each with its name, and returns the paths.
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
