//! [`History`], which writes the history of a run.

use super::appended::Appended;
use super::rows::{
    DESIGNS, DESIGNS_FORMAT, DesignRow, FORMAT, HistoryRow, LINES, TABLE, design_rows, header, line,
};
use crate::codesign::Record;
use crate::error::Result;
use std::path::Path;

/// The files of a history, open, so that lines can be appended. The caller holds the lock on the folder.
#[derive(Debug)]
pub(in crate::record) struct History {
    lines: Appended,
    table: Appended,
    designs: Appended,
    /// The number of the iteration before the run's first one.
    entered: usize,
}

impl History {
    /// Opens the history of a run whose first iteration is `entered + 1`, and removes the lines of all iterations after
    /// `iteration`. If no line remains, begins a new history.
    ///
    /// # Errors
    /// [`Error::Read`](crate::Error::Read) for a missing file and [`Error::Misfit`](crate::Error::Misfit) for missing
    /// lines, in both cases before any file has changed; [`Error::Write`](crate::Error::Write).
    pub(in crate::record) fn open(folder: &Path, entered: usize, iteration: usize) -> Result<Self> {
        let rows = iteration.saturating_sub(entered);
        let begins = rows == 0;
        let open = |name| Appended::open(folder.join(name), begins);
        let mut history = Self {
            lines: open(LINES)?,
            table: open(TABLE)?,
            designs: open(DESIGNS)?,
            entered,
        };
        // The table has one line more, its header.
        let ends = [
            history.lines.end(rows)?,
            history.designs.end(design_rows(entered, entered + rows))?,
            history.table.end(rows + usize::from(!begins))?,
        ];
        history.lines.cut(ends[0])?;
        history.designs.cut(ends[1])?;
        history.table.cut(ends[2])?;
        if begins {
            history.table.append(&header())?;
        }
        Ok(history)
    }

    /// Appends the record of an iteration. `seconds` is the wall time of the run so far.
    pub(in crate::record) fn append(&mut self, record: &Record, seconds: f64) -> Result<()> {
        let record = record.clone();
        let row = HistoryRow { record, seconds };
        self.table.append(&line(&row))?;
        self.lines.append(&FORMAT.line(&row))
    }

    /// True for the iterations whose designs are kept: the first iteration of the run, and every iteration whose number
    /// is a multiple of ten.
    pub(in crate::record) fn keeps_design(&self, iteration: usize) -> bool {
        let rows = |iteration| design_rows(self.entered, iteration);
        rows(iteration) != rows(iteration - 1)
    }

    /// Appends the design after an iteration that [keeps](Self::keeps_design) it.
    pub(in crate::record) fn append_design(&mut self, row: &DesignRow) -> Result<()> {
        self.designs.append(&DESIGNS_FORMAT.line(row))
    }

    /// Flushes the lines to the disk. This is called before a snapshot is written, so that even after a power cut the
    /// files have the lines of all iterations that the snapshot counts.
    pub(in crate::record) fn sync(&self) -> Result<()> {
        let files = [&self.lines, &self.table, &self.designs];
        files.into_iter().try_for_each(Appended::sync)
    }
}

#[cfg(test)]
mod tests {
    use super::{DESIGNS, DesignRow, History, LINES, TABLE};
    use crate::codesign::tests::{records, tiny};
    use crate::record::history::read;
    use std::fs;

    #[test]
    fn lines_read_back_and_the_table_has_a_cell_for_every_column() {
        let folder = tempfile::tempdir().unwrap();
        let mut scene = tiny();
        scene.schedule.iterations = 4;
        (scene.schedule.attraction_from, scene.schedule.snap_at) = (2, 3);
        let records = records(&scene);
        let mut history = History::open(folder.path(), 0, 0).unwrap();
        records
            .iter()
            .for_each(|record| history.append(record, 0.25).unwrap());
        assert_eq!(read(folder.path(), 4).unwrap(), records);
        let table = fs::read_to_string(folder.path().join(TABLE)).unwrap();
        let cells: Vec<usize> = table.lines().map(|line| line.split(',').count()).collect();
        assert_eq!(cells, [cells[0]; 5]);
        assert!(table.starts_with("iteration,phase,pass,displacement,"));
        assert!(table.lines().nth(3).unwrap().starts_with("3,snap,,,"));
    }

    #[test]
    fn designs_are_kept_after_the_first_and_every_tenth_iteration() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(DESIGNS);
        let mut history = History::open(folder.path(), 0, 0).unwrap();
        let z = |iteration: usize| [[1.0 / iteration as f64, 0.0, 1.0]];
        let kept: Vec<usize> = (1..=21).filter(|k| history.keeps_design(*k)).collect();
        for k in kept {
            let row = DesignRow::new(k, &z(k), None);
            history.append_design(&row).unwrap();
        }
        let text = fs::read_to_string(&file).unwrap();
        let row = |line| serde_json::from_str::<DesignRow>(line).unwrap();
        let rows: Vec<_> = text.lines().map(row).collect();
        let seen: Vec<_> = rows
            .iter()
            .map(|row| (row.iteration, row.z[0][0]))
            .collect();
        assert_eq!(seen, [(1, 1.0), (10, 0.1), (20, 0.05)]);
        drop(history);
        // A run is resumed after nine iterations, so every file is cut there. The other two files must have lines.
        for name in [LINES, TABLE] {
            fs::write(folder.path().join(name), "\n".repeat(10)).unwrap();
        }
        drop(History::open(folder.path(), 0, 9).unwrap());
        assert_eq!(fs::read_to_string(&file).unwrap().lines().count(), 1);
    }
}
