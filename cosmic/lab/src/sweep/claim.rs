//! Who works on a run: whoever holds the lock of its claim.

use cosmic::error::{Error, Result};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::Path;

/// The right to work on one run, until it is dropped. The system takes it back from a process that
/// ends in any way: a claim cannot outlive its holder, and a file that is left behind claims
/// nothing.
#[derive(Debug)]
pub(super) struct Claim {
    _lock: File,
}

impl Claim {
    /// Claims a run; `None` where another process, or another thread of this one, has it.
    ///
    /// # Errors
    /// [`Error::Write`] where claims cannot be made.
    pub(super) fn take(sweep: &Path, name: &str) -> Result<Option<Self>> {
        let folder = sweep.join("claims");
        let path = folder.join(name);
        let write = |source| Error::Write {
            path: path.clone(),
            source,
        };
        fs::create_dir_all(&folder).map_err(write)?;
        let mut options = OpenOptions::new();
        let options = options.write(true).create(true).truncate(false);
        let file = options.open(&path).map_err(write)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Self { _lock: file })),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(source)) => Err(write(source)),
        }
    }
}
