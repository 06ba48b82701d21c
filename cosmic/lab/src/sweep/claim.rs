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

#[cfg(test)]
mod tests {
    use super::Claim;

    #[test]
    fn one_holder_at_a_time_and_none_after_it() {
        let folder = tempfile::tempdir().unwrap();
        let take = |name| Claim::take(folder.path(), name).unwrap();
        let held = take("a-0").expect("nobody has it");
        assert!(take("a-0").is_none());
        assert!(take("a-1").is_some());
        drop(held);
        // The file is still there, as after a process that was killed.
        assert!(folder.path().join("claims/a-0").exists() && take("a-0").is_some());
    }
}
