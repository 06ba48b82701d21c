//! Text files that grow by lines, and can be cut back.

use crate::error::{Error, Result, fits};
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

/// A text file that grows by lines.
#[derive(Debug)]
pub(super) struct Appended {
    path: PathBuf,
    file: File,
}

impl Appended {
    /// Opens a file. Creates it only if a history begins: a lost file is an error.
    pub(super) fn open(path: PathBuf, create: bool) -> Result<Self> {
        let mut options = OpenOptions::new();
        let options = options.read(true).write(true).create(create);
        match options.truncate(false).open(&path) {
            Ok(file) => Ok(Self { path, file }),
            Err(error) if !create && error.kind() == ErrorKind::NotFound => {
                Err(Error::reading(path)(error))
            }
            Err(error) => Err(Error::writing(path)(error)),
        }
    }

    /// The length of the first `lines` lines in bytes.
    pub(super) fn end(&mut self, lines: usize) -> Result<u64> {
        let mut bytes = Vec::new();
        (self.file.seek(SeekFrom::Start(0)))
            .and_then(|_| self.file.read_to_end(&mut bytes))
            .map_err(Error::reading(&self.path))?;
        let ends: Vec<usize> = (1..=bytes.len())
            .filter(|&n| bytes[n - 1] == b'\n')
            .collect();
        let (file, found) = (self.path.display().to_string(), ends.len().min(lines));
        fits(&file, "lines up to the snapshot", found, lines)?;
        Ok(lines.checked_sub(1).map_or(0, |last| ends[last] as u64))
    }

    /// Truncates the file and moves to its end.
    pub(super) fn cut(&mut self, length: u64) -> Result<()> {
        (self.file.set_len(length))
            .and_then(|()| self.file.seek(SeekFrom::Start(length)))
            .map(drop)
            .map_err(Error::writing(&self.path))
    }

    /// Appends a line in one write: a killed process leaves at most its last line unfinished.
    pub(super) fn append(&mut self, line: &str) -> Result<()> {
        (self.file.write_all(line.as_bytes())).map_err(Error::writing(&self.path))
    }

    /// Flushes the lines to the disk.
    pub(super) fn sync(&self) -> Result<()> {
        self.file.sync_data().map_err(Error::writing(&self.path))
    }
}
