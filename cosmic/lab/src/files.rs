//! Files of text.

use cosmic::error::Result;
use cosmic::record::files::write_atomic;
use std::path::{Path, PathBuf};

/// Replaces a file by a text.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<()> {
    write_atomic(path, |file| file.write_all(text.as_bytes()))
}

/// Replaces files of a folder by texts, each with the name of its file, and gives their paths.
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
