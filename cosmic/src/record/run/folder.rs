//! The folder of a run: locking it, beginning a run in it, and reading its scene and its summary.

use super::claim::{self, Claim, PAUSE, TRIES};
use crate::error::{Error, Result, command};
use crate::outcome::Summary;
use crate::record::damaged::explained;
pub use crate::record::files::SCENE;
use crate::record::files::{LOCK, is_used, make_folder, read_json, write_atomic};
use crate::record::snapshot::{SNAPSHOT, Snapshot};
use crate::record::summary::{self, SUMMARY, result_of};
use crate::registry::Registry;
use crate::scene::{Scene, TrussFile};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// A lock on a folder, held until this value is dropped. The operating system locks a file in the folder for the
/// process. It releases the lock when the process ends, whatever the reason. A lock file that is left behind does not
/// lock the folder. Where the file system refuses locks, a [claim](Claim) takes the place of the lock.
#[derive(Debug)]
pub(in crate::record) struct Lock {
    folder: PathBuf,
    _file: File,
    /// The claim, and why there is no lock.
    claim: Option<(Claim, io::Error)>,
}

impl Lock {
    /// Locks an existing folder.
    pub(in crate::record) fn take(folder: &Path) -> Result<Self> {
        let mut options = OpenOptions::new();
        let options = options.write(true).create(true).truncate(false);
        let file = options.open(folder.join(LOCK));
        let file = file.map_err(Error::writing(folder))?;
        for _ in 0..TRIES {
            let claim = match file.try_lock() {
                Err(TryLockError::WouldBlock) => {
                    thread::sleep(PAUSE);
                    continue;
                }
                Ok(()) => None,
                Err(TryLockError::Error(refusal)) => Some((Claim::take(folder)?, refusal)),
            };
            return Ok(Self {
                folder: folder.to_owned(),
                _file: file,
                claim,
            });
        }
        Err(Error::Taken(folder.to_owned()))
    }

    /// A warning if the file system refuses locks. A process gives it once.
    pub(super) fn warning(&self) -> Option<String> {
        static IS_SAID: AtomicBool = AtomicBool::new(false);
        let (claim, refusal) = self.claim.as_ref()?;
        (!IS_SAID.swap(true, Ordering::Relaxed)).then(|| {
            format!(
                "the file system refuses locks ({refusal}); files such as {} keep other processes out of a run instead",
                claim.file.display()
            )
        })
    }

    /// The locked folder.
    pub(in crate::record) fn folder(&self) -> &Path {
        &self.folder
    }

    /// Releases the folder of a finished run and removes the lock file. The lock file of an unfinished run must not be
    /// removed, because one process could hold the old file open while another creates and locks a new one.
    pub(in crate::record) fn finish(self) {
        // A lock file that cannot be removed does no harm.
        let _ = fs::remove_file(self.folder.join(LOCK));
        claim::remove_all(&self.folder);
    }
}

/// Creates a folder, or uses an empty one, and locks it before the first write.
pub(in crate::record) fn begin(folder: &Path) -> Result<Lock> {
    // The first check is without a lock, so that a refused folder does not change.
    refuse_used(folder)?;
    make_folder(folder)?;
    let lock = Lock::take(folder)?;
    // Another process may have filled the folder before it released the lock.
    refuse_used(folder)?;
    Ok(lock)
}

/// Locks the folder of a run and reads its snapshot. Returns `None` if the run is finished.
pub(in crate::record) fn take_up(
    folder: &Path,
    registry: &Registry,
) -> Result<Option<(Lock, Snapshot)>> {
    let is_finished = || folder.join(SUMMARY).exists();
    if is_finished() {
        return Ok(None);
    }
    // The first check is without a lock, so that a folder without a run does not change.
    snapshot(folder, registry)?;
    let lock = Lock::take(folder)?;
    // Another process may have continued or finished the run before it released the lock.
    if is_finished() {
        lock.finish();
        return Ok(None);
    }
    Ok(Some((lock, snapshot(folder, registry)?)))
}

/// Reads the snapshot of a folder, and checks that `scene.toml` has its scene.
fn snapshot(folder: &Path, registry: &Registry) -> Result<Snapshot> {
    let (file, scene) = (folder.join(SNAPSHOT), folder.join(SCENE));
    let snapshot = Snapshot::read(folder, registry).map_err(explained(&file))?;
    if scene.exists() {
        read_kept(&scene, Some(&snapshot.plan.scene), registry)?;
    }
    Ok(snapshot)
}

/// Writes the scene to the folder, and the truss of its lattice if there is one. Existing files stay. The files are for
/// people and for other commands; a resumed run uses the scene of the snapshot.
pub(in crate::record) fn keep_scene(folder: &Path, scene: &Scene) -> Result<()> {
    let path = folder.join(SCENE);
    let mut kept = scene.clone();
    if let Some(truss) = scene.lattice.file.truss() {
        let copy = folder.join(TrussFile::COPY);
        if !copy.exists() {
            write_atomic(&copy, |file| file.write_all(truss.to_json().as_bytes()))?;
        }
        kept.lattice.file = TrussFile::new(TrussFile::COPY, Arc::clone(truss));
    }
    if path.exists() {
        return Ok(());
    }
    write_atomic(&path, |file| file.write_all(kept.to_run_toml().as_bytes()))
}

/// Reads the summary of a finished run.
///
/// # Errors
/// [`Error::Read`] for a run that is not finished; [`Error::Malformed`] for a damaged summary.
pub fn read_summary(folder: &Path) -> Result<Summary> {
    let file = result_of(folder, SUMMARY)?;
    read_json(&file, summary::FORMAT).map_err(explained(&file))
}

/// Reads `scene.toml`, the scene of the run or of the single design in a folder. The file must agree with the snapshot of
/// the run, if there is one. If the file is missing, the scene is read from the snapshot.
///
/// # Errors
/// [`Error::Usage`] if the file differs from the scene of the snapshot; the errors of [`Registry::read`];
/// [`Error::Read`].
pub fn read_scene(folder: &Path, registry: &Registry) -> Result<Scene> {
    let path = folder.join(SCENE);
    let begun_with =
        || Snapshot::scene(folder, registry).map_err(explained(&folder.join(SNAPSHOT)));
    if !path.exists()
        && let Some(scene) = begun_with()?
    {
        return Ok(scene);
    }
    // An error in the file is reported before an error in the snapshot.
    let scene = read_kept(&path, None, registry)?;
    match begun_with()? {
        Some(begun_with) => read_kept(&path, Some(&begun_with), registry),
        None => Ok(scene),
    }
}

/// Reads a scene file. If `begun_with` is given, the file must contain that scene, with which the run began.
fn read_kept(path: &Path, begun_with: Option<&Scene>, registry: &Registry) -> Result<Scene> {
    let scene = registry.read(path).map_err(explained(path))?;
    if begun_with.is_some_and(|begun_with| *begun_with != scene) {
        return Err(Error::Usage(format!(
            "{}: this is not the scene with which the run began; remove the file to use the scene in \
             the run's snapshot, or use --set or another folder to try a design in another scene",
            path.display()
        )));
    }
    Ok(scene)
}

/// Refuses a folder that is not empty, so that a run never mixes its files with others.
fn refuse_used(folder: &Path) -> Result<()> {
    match is_used(folder) {
        Ok(false) => Ok(()),
        Ok(true) => Err(Error::Usage(format!(
            "{}: the folder is not empty{}, or name another folder",
            folder.display(),
            if folder.join(SNAPSHOT).exists() || folder.join(SUMMARY).exists() {
                format!("; continue its run with `{}`", command("resume"))
            } else {
                ", but it does not contain a run; empty it".to_owned()
            }
        ))),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        Err(error) => Err(Error::writing(folder)(error)),
    }
}
