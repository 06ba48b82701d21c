//! The right to work on a run: a lock on a file.

use cosmic::error::{Error, Result};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::Path;

/// Claims a run until the file is dropped. `None` if another process, or another thread of this one,
/// holds the claim. The system releases the lock when a process ends, however it ends: a file that is
/// left behind claims nothing.
///
/// # Errors
/// [`Error::Write`] if claims cannot be made.
pub(super) fn claim(sweep: &Path, name: &str) -> Result<Option<File>> {
    let folder = sweep.join("claims");
    let path = folder.join(name);
    fs::create_dir_all(&folder).map_err(Error::writing(&path))?;
    let mut options = OpenOptions::new();
    let options = options.write(true).create(true).truncate(false);
    let file = options.open(&path).map_err(Error::writing(&path))?;
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Ok(None),
        Err(TryLockError::Error(source)) => Err(Error::writing(&path)(source)),
    }
}
