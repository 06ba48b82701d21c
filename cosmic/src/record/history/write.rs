//! [`History`], which writes the history of a run.

use super::rows::{DESIGNS, DESIGNS_FORMAT, DesignRow, FORMAT, HistoryRow, LINES, design_rows};
use crate::error::{Error, Result};
use crate::record::files::begin_again;
use crate::search::Record;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The files of a history, open, so that lines can be appended. The caller holds the lock on the folder.
#[derive(Debug)]
pub struct History {
    lines: Appended,
    designs: Appended,
    /// The number of the iteration before the run's first one.
    entered: usize,
}

impl History {
    /// Opens the history of a run whose first iteration is `entered + 1`, and removes the lines of all iterations after
    /// `iteration`. If no line remains, begins a new history.
    ///
    /// # Errors
    /// [`Error::Read`] for a missing file and [`Error::Usage`] for missing
    /// lines, in both cases before any file has changed; [`Error::Write`].
    pub fn open(folder: &Path, entered: usize, iteration: usize) -> Result<Self> {
        let rows = iteration.saturating_sub(entered);
        let begins = rows == 0;
        let open = |name| Appended::open(folder.join(name), begins);
        let mut history = Self {
            lines: open(LINES)?,
            designs: open(DESIGNS)?,
            entered,
        };
        let ends = [
            history.lines.end(rows)?,
            history.designs.end(design_rows(entered, entered + rows))?,
        ];
        history.lines.cut(ends[0])?;
        history.designs.cut(ends[1])?;
        Ok(history)
    }

    /// Appends the record of an iteration. `seconds` is the wall time of the run so far.
    pub fn append(&mut self, record: &Record, seconds: f64) -> Result<()> {
        let record = record.clone();
        let row = HistoryRow { record, seconds };
        self.lines.append(&FORMAT.line(&row))
    }

    /// True for the iterations whose designs are kept: the first iteration of the run, and every iteration whose number
    /// is a multiple of ten.
    pub fn keeps_design(&self, iteration: usize) -> bool {
        let rows = |iteration| design_rows(self.entered, iteration);
        rows(iteration) != rows(iteration - 1)
    }

    /// Appends the design after an iteration that [keeps](Self::keeps_design) it.
    pub fn append_design(&mut self, row: &DesignRow) -> Result<()> {
        self.designs.append(&DESIGNS_FORMAT.line(row))
    }

    /// Flushes the lines to the disk. This is called before a snapshot is written, so that even after a power cut the
    /// files have the lines of all iterations that the snapshot counts.
    pub(in crate::record) fn sync(&self) -> Result<()> {
        let files = [&self.lines, &self.designs];
        files.into_iter().try_for_each(Appended::sync)
    }
}

/// A text file that is open, so that lines can be appended.
#[derive(Debug)]
struct Appended {
    path: PathBuf,
    file: File,
}

impl Appended {
    /// Opens a file. If it is missing, creates it if `create` is true, and returns an error otherwise.
    fn open(path: PathBuf, create: bool) -> Result<Self> {
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
    fn end(&mut self, lines: usize) -> Result<u64> {
        let mut bytes = Vec::new();
        (self.file.rewind())
            .and_then(|()| self.file.read_to_end(&mut bytes))
            .map_err(Error::reading(&self.path))?;
        let whole = bytes.split_inclusive(|&byte| byte == b'\n');
        // A crash of the machine can leave any bytes in a line.
        let is_whole = |line: &&[u8]| line.starts_with(b"{") && line.ends_with(b"}\n");
        let is_text = |line: &&[u8]| !line.contains(&0) && str::from_utf8(line).is_ok();
        let whole = whole.take_while(|line| is_whole(line) && is_text(line));
        let lengths: Vec<usize> = whole.take(lines).map(<[u8]>::len).collect();
        if lengths.len() < lines {
            return Err(Error::Usage(format!(
                "{}: expected {lines} lines up to the snapshot, found {}; if the folder is a copy that was made during the \
                 run, copy it again; otherwise the file is damaged: restore it from a copy, or {}",
                self.path.display(),
                lengths.len(),
                begin_again(self.path.parent().unwrap_or(Path::new("")))
            )));
        }
        Ok(lengths.iter().sum::<usize>() as u64)
    }

    /// Truncates the file to `length` bytes, so that the next line is appended there.
    fn cut(&mut self, length: u64) -> Result<()> {
        (self.file.set_len(length))
            .and_then(|()| self.file.seek(SeekFrom::Start(length)))
            .map(drop)
            .map_err(Error::writing(&self.path))
    }

    /// Appends a line in one write, so that a killed process leaves at most one unfinished line.
    fn append(&mut self, line: &str) -> Result<()> {
        (self.file.write_all(line.as_bytes())).map_err(Error::writing(&self.path))
    }

    /// Flushes the lines to the disk.
    fn sync(&self) -> Result<()> {
        self.file.sync_data().map_err(Error::writing(&self.path))
    }
}
