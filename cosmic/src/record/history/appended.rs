//! Text files to which lines are appended and which can be truncated.

use crate::error::{Error, Result};
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;

/// A text file that is open, so that lines can be appended.
#[derive(Debug)]
pub(super) struct Appended {
    path: PathBuf,
    file: File,
}

impl Appended {
    /// Opens a file. If it is missing, creates it if `create` is true, and returns an error otherwise.
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

    /// The length of the first `lines` lines, in bytes. Returns an error if the file has fewer complete lines.
    pub(super) fn end(&mut self, lines: usize) -> Result<u64> {
        let mut bytes = Vec::new();
        (self.file.rewind())
            .and_then(|()| self.file.read_to_end(&mut bytes))
            .map_err(Error::reading(&self.path))?;
        let whole = bytes.split_inclusive(|&byte| byte == b'\n');
        let whole = whole.filter(|line| line.ends_with(b"\n"));
        let lengths: Vec<usize> = whole.take(lines).map(<[u8]>::len).collect();
        if lengths.len() < lines {
            return Err(Error::Usage(format!(
                "{}: expected {lines} lines up to the snapshot, found {}; if the folder is a copy that was made during the \
                 run, copy it again",
                self.path.display(),
                lengths.len()
            )));
        }
        Ok(lengths.iter().sum::<usize>() as u64)
    }

    /// Truncates the file to `length` bytes, so that the next line is appended there.
    pub(super) fn cut(&mut self, length: u64) -> Result<()> {
        (self.file.set_len(length))
            .and_then(|()| self.file.seek(SeekFrom::Start(length)))
            .map(drop)
            .map_err(Error::writing(&self.path))
    }

    /// Appends a line in one write, so that a killed process leaves at most one unfinished line.
    pub(super) fn append(&mut self, line: &str) -> Result<()> {
        (self.file.write_all(line.as_bytes())).map_err(Error::writing(&self.path))
    }

    /// Flushes the lines to the disk.
    pub(super) fn sync(&self) -> Result<()> {
        self.file.sync_data().map_err(Error::writing(&self.path))
    }
}
