//! A run's folder belongs to one process at a time: whoever holds its lock.

use crate::error::{Error, Result};
use crate::record::files::{LOCK, is_used, make_folder, write_atomic};
use crate::record::snapshot::{SNAPSHOT, Snapshot};
use crate::record::summary::SUMMARY;
use crate::scene::Scene;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The scene's place in a run's folder.
pub const SCENE: &str = "scene.toml";

/// The right to work in a folder, until it is dropped. The system takes it back from a process that
/// ends in any way: the file that is left behind locks nothing.
#[derive(Debug)]
pub(in crate::record) struct Lock {
    folder: PathBuf,
    _file: File,
}

impl Lock {
    /// Locks a folder, which must be there.
    ///
    /// # Errors
    /// [`Error::Taken`]; [`Error::Write`].
    fn take(folder: &Path) -> Result<Self> {
        let path = folder.join(LOCK);
        let mut options = OpenOptions::new();
        let options = options.write(true).create(true).truncate(false);
        let file = match options.open(&path) {
            Ok(file) => file,
            Err(source) => return Err(Error::Write { path, source }),
        };
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(Error::Taken(folder.to_owned())),
            // Not every file system has locks: without one, two processes are the user's affair.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(Self {
                folder: folder.to_owned(),
                _file: file,
            }),
        }
    }

    /// The folder that is locked.
    pub(in crate::record) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Gives up a folder whose run is finished, and takes the file away. From no other folder: who
    /// has opened the file by then, and who makes a new one, would both have a lock.
    pub(in crate::record) fn finish(self) {
        // One that stays does no harm.
        let _ = fs::remove_file(self.folder.join(LOCK));
    }
}

/// A new or empty folder, locked: of two that begin there one has it, before either writes.
///
/// # Errors
/// [`Error::Usage`] for a folder that holds something; [`Error::Taken`]; [`Error::Write`].
pub(in crate::record) fn begin(folder: &Path) -> Result<Lock> {
    // Not even a lock is left in a folder that is refused.
    refuse_used(folder)?;
    make_folder(folder)?;
    let lock = Lock::take(folder)?;
    // Whoever had it until just now may have filled it.
    refuse_used(folder)?;
    Ok(lock)
}

/// A run's folder, locked, and its snapshot; `None` for a run that is finished.
///
/// # Errors
/// Those of [`Snapshot::read`]; [`Error::Taken`]; [`Error::Write`].
pub(in crate::record) fn take_up(folder: &Path) -> Result<Option<(Lock, Snapshot<'static>)>> {
    let is_finished = || folder.join(SUMMARY).exists();
    if is_finished() {
        return Ok(None);
    }
    // Where there is no run, no lock is left.
    Snapshot::read(folder)?;
    let lock = Lock::take(folder)?;
    // Whoever had it until just now may have gone on, or finished.
    if is_finished() {
        lock.finish();
        return Ok(None);
    }
    Ok(Some((lock, Snapshot::read(folder)?)))
}

/// Writes the scene for those who read the folder. It is not read to go on: one that says
/// something else by now would mislead, and is refused.
pub(in crate::record) fn keep_scene(folder: &Path, scene: &Scene) -> Result<()> {
    let path = folder.join(SCENE);
    if !path.exists() {
        return write_atomic(&path, |file| file.write_all(scene.to_toml().as_bytes()));
    }
    if Scene::read(&path)? != *scene {
        return Err(Error::Usage(format!(
            "{}: not the scene that the run began with, which is in its snapshot; remove the \
             file to get it back",
            path.display()
        )));
    }
    Ok(())
}

/// A run never mixes its files with others.
fn refuse_used(folder: &Path) -> Result<()> {
    match is_used(folder) {
        Ok(false) => Ok(()),
        Ok(true) => Err(Error::Usage(format!(
            "{}: the folder is not empty{}, or name another",
            folder.display(),
            if folder.join(SNAPSHOT).exists() || folder.join(SUMMARY).exists() {
                "; go on with the run in it by `cosmic resume`"
            } else {
                ", and no run is in it: empty it"
            }
        ))),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(source) => Err(Error::Write {
            path: folder.into(),
            source,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::{LOCK, begin, take_up};
    use crate::record::files::sweep;
    use std::fs;

    #[test]
    fn one_begins_at_a_time_and_in_an_empty_folder_alone() {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("a");
        let refusal = || begin(&run).unwrap_err().to_string();
        let lock = begin(&run).unwrap();
        assert!(refusal().contains("another process is at work"));
        // Two files of its name would be two locks.
        sweep(&run).unwrap();
        assert!(refusal().contains("another process is at work"));
        drop(lock);
        drop(begin(&run).unwrap());
        fs::write(run.join("b"), "").unwrap();
        assert!(refusal().contains("not empty"));
    }

    #[test]
    fn a_refusal_leaves_no_lock() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(take_up(folder.path()).unwrap_err().exit_code(), 4);
        fs::write(folder.path().join("b"), "").unwrap();
        assert_eq!(begin(folder.path()).unwrap_err().exit_code(), 2);
        assert!(!folder.path().join(LOCK).exists());
    }
}
