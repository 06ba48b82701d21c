//! [`History`], which writes the history of a run.

use super::appended::Appended;
use super::rows::{DESIGNS, DESIGNS_FORMAT, DesignRow, FORMAT, HistoryRow, LINES, design_rows};
use crate::codesign::Record;
use crate::error::Result;
use std::path::Path;

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
    /// [`Error::Read`](crate::Error::Read) for a missing file and [`Error::Usage`](crate::Error::Usage) for missing
    /// lines, in both cases before any file has changed; [`Error::Write`](crate::Error::Write).
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
