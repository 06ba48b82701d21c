//! Atomic writes: a file is written under a temporary name and then renamed, so that readers never see half of the
//! file.

use crate::error::{Error, Result, command, in_shell};
use crate::format::{Format, Stamped, parse_json};
use crate::outcome::DesignFile;
use crate::reading::read_whole;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// Replaces a file by the output of `fill`. Readers find either the whole old file or the whole new file, even after a
/// crash.
///
/// # Errors
/// [`Error::Write`], also if `fill` returns an error.
pub fn write_atomic(
    path: &Path,
    mut fill: impl FnMut(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    replace(path, &mut fill).map_err(Error::writing(path))
}

type Fill<'a> = &'a mut dyn FnMut(&mut dyn Write) -> io::Result<()>;

fn replace(path: &Path, fill: Fill) -> io::Result<()> {
    // Links are followed. Pipes and devices are written directly.
    let path = &match fs::metadata(path) {
        Ok(found) if found.is_file() || found.is_dir() => path.canonicalize()?,
        Ok(_) => {
            let mut file = BufWriter::new(OpenOptions::new().write(true).open(path)?);
            fill(&mut file)?;
            return file.flush();
        }
        // A new file, or a link to a file that does not exist.
        Err(_) => fs::read_link(path).map_or(path.to_owned(), |target| path.with_file_name(target)),
    };
    // The parent of `file.json` is empty, which means the current folder.
    let parent = path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty());
    let folder = parent.unwrap_or(Path::new("."));
    let file = temporary(folder)?;
    // Errors of `file` itself would name the temporary file, but the user knows only `path`.
    let mut out = BufWriter::new(file.as_file());
    fill(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?;
    // The new file keeps the permissions of the old one.
    #[cfg(unix)]
    if let Ok(replaced) = fs::metadata(path) {
        file.as_file().set_permissions(replaced.permissions())?;
    }
    // The data must reach the disk before the rename: otherwise a power cut could leave an empty file.
    file.as_file().sync_all()?;
    file.persist(path)?;
    // On Unix, a rename reaches the disk only when the folder is synchronised.
    if cfg!(unix) {
        File::open(folder)?.sync_all()?;
    }
    Ok(())
}

/// The name of the scene in the folder of a run.
pub const SCENE: &str = "scene.toml";

/// The name of the design in the folder of a run.
pub const DESIGN: &str = "design.json";

/// The end of a message: the command that begins the run in a folder again.
pub(super) fn begin_again(folder: &Path) -> String {
    let scene = in_shell(&folder.join(SCENE));
    let again = command(format_args!("optimize {scene} --seed SEED --out NEW"));
    format!("begin again with: {again}")
}

/// Prefix of the names of temporary files.
const TEMPORARY: &str = ".cosmic-";

/// The name of the lock, an empty file in the folder of a run that is not finished.
pub(in crate::record) const LOCK: &str = ".cosmic-lock";

/// The beginning of the names of claims, which take the place of the lock where the file system refuses locks.
pub(in crate::record) const CLAIM: &str = ".cosmic-claim-";

/// True for the name of the lock or of a claim.
fn is_lock(name: &OsStr) -> bool {
    name == LOCK || name.to_string_lossy().starts_with(CLAIM)
}

/// True if a process holds the lock of the run in a folder.
pub(super) fn is_taken(folder: &Path) -> bool {
    let lock = File::open(folder.join(LOCK));
    // The lock is shared, so that two processes that only look at a run do not take each other for its owner.
    lock.is_ok_and(|lock| matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// True for the name of a temporary file.
fn is_temporary(name: &OsStr) -> bool {
    !is_lock(name) && name.to_string_lossy().starts_with(TEMPORARY)
}

/// True if a folder contains any files other than the lock, claims and temporary files that killed processes left.
///
/// # Errors
/// The error of the operating system if the folder cannot be listed.
pub fn is_used(folder: &Path) -> io::Result<bool> {
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        if !is_lock(&name) && !is_temporary(&name) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Removes the temporary files of killed processes from a folder. No other process may be writing there, but another one
/// may be checking the folder ([`make_folder`]).
///
/// # Errors
/// [`Error::Write`].
pub fn sweep(folder: &Path) -> Result<()> {
    let remove = || -> io::Result<()> {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            if is_temporary(&entry.file_name()) {
                match fs::remove_file(entry.path()) {
                    // The process that made the file was faster.
                    Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                    result => result?,
                }
            }
        }
        Ok(())
    };
    remove().map_err(Error::writing(folder))
}

/// Creates a folder if it does not exist, and checks that files can be created in it.
///
/// # Errors
/// [`Error::Write`].
pub fn make_folder(folder: &Path) -> Result<()> {
    let made = fs::create_dir_all(folder).and_then(|()| temporary(folder).map(drop));
    made.map_err(Error::writing(folder))
}

/// The error for a folder that does not hold a run: the file with the name `lacks` is missing. If a folder inside it is
/// the folder of a run, the error names that folder.
pub(super) fn no_run(folder: &Path, lacks: &str) -> Error {
    let refused = |says: String| Error::reading(folder)(io::Error::other(says));
    match fs::metadata(folder) {
        Err(source) => return Error::reading(folder)(source),
        Ok(found) if !found.is_dir() => {
            return refused("it is a file; name the folder of a run".to_owned());
        }
        Ok(_) => {}
    }
    let run_in = |folder: &Path| -> Option<PathBuf> {
        let entries = fs::read_dir(folder).ok()?;
        let folders = entries.filter_map(|entry| Some(entry.ok()?.path()));
        folders.filter(|folder| folder.join(lacks).exists()).min()
    };
    let there = run_in(folder).or_else(|| run_in(&folder.join("runs")));
    let advice = there.map_or_else(
        || "name the folder that `cosmic optimize` wrote".to_owned(),
        |run| format!("a run is in {}", run.display()),
    );
    refused(format!(
        "it is not the folder of a run, because it has no {lacks}; {advice}"
    ))
}

/// Creates a temporary file in a folder. The file is removed when the value is dropped, unless the file was renamed
/// before.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    // In contrast to `tempfile_in`, this makes an ordinary file, which is not private.
    Builder::new()
        .prefix(TEMPORARY)
        .make_in(folder, |path| File::create_new(path))
}

/// Copies files of one folder to another.
pub(super) fn copy_files(from: &Path, to: &Path, names: &[&str]) -> Result<()> {
    names.iter().try_for_each(|name| {
        let path = from.join(name);
        let bytes = fs::read(&path).map_err(Error::reading(path))?;
        write_atomic(&to.join(name), |file| file.write_all(&bytes))
    })
}

/// Writes a JSON file, or replaces it. The file has the keys `format` and `version`, then the keys of the body. Numbers
/// that are written and read back have the same bits; NaN and infinities become `null`.
///
/// # Errors
/// [`Error::Write`].
pub fn write_json<T: Serialize>(path: &Path, format: Format, body: &T) -> Result<()> {
    write_atomic(path, |file| {
        serde_json::to_writer(&mut *file, &Stamped { format, body })?;
        writeln!(file)
    })
}

impl DesignFile {
    /// Writes this design to a file, and replaces the file if it exists.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path) -> Result<()> {
        write_json(path, Self::FORMAT, self)
    }
}

/// Reads a file that [`write_json`] wrote. `T` must accept the keys `format` and `version`.
///
/// # Errors
/// [`Error::Read`] for a file that is missing or unreadable; [`Error::Malformed`] for a file that is not JSON, has
/// another format or version, or lacks keys.
pub fn read_json<T: DeserializeOwned>(path: &Path, format: Format) -> Result<T> {
    parse_json(path, &read_whole(path)?, format)
}
