//! Writes `results.csv`, the results of all runs, and makes a table with a row for each trial.

use super::{Plan, Trial};
use crate::files::write_text;
use crate::statistics::Statistics;
use crate::table::{Cell, Column, Table};
use cosmic::error::{Error, Result, command};
use cosmic::judge::Quantiles;
use cosmic::outcome::{Summary, ratio};
use cosmic::record::run::read_summary;
use cosmic::record::summary::SUMMARY;
use rayon::prelude::*;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The results of a sweep.
#[derive(Clone, Debug)]
pub struct Merged {
    /// The path of the results of all runs, a CSV file.
    pub results: PathBuf,
    /// The table with the median over the seeds and other numbers of each trial.
    pub table: Table,
    /// The number of unfinished runs.
    pub missing: usize,
    /// The names of the unreliable runs.
    pub unreliable: Vec<String>,
}

/// A run and its summary.
struct MergedRun<'p> {
    index: usize,
    trial: &'p Trial,
    seed: u64,
    state: &'static str,
    summary: Option<Summary>,
}

/// The summaries are read in blocks, so that the memory does not grow with the number of runs. This is the number of runs
/// in a block.
const AT_ONCE: usize = 256;

/// Writes the results of the finished runs into the folder of a sweep, and returns them.
///
/// # Errors
/// The errors of [`Plan::read`] and [`read_summary`]; [`Error::Usage`] for the summary of another run;
/// [`Error::Write`].
pub fn merge(sweep: &Path) -> Result<Merged> {
    let plan = Plan::read(sweep)?;
    let (mut csv, mut unreliable) = (String::new(), Vec::new());
    let mut rows: Vec<Row> = plan.trials.iter().map(Row::new).collect();
    for first in (0..plan.runs()).step_by(AT_ONCE) {
        let block = first..plan.runs().min(first + AT_ONCE);
        let read = |index| MergedRun::read(sweep, &plan, index);
        let block: Vec<MergedRun> = block.into_par_iter().map(read).collect::<Result<_>>()?;
        for run in &block {
            if run.summary.as_ref().is_some_and(Summary::is_unreliable) {
                unreliable.push(plan.name(run.index));
            }
            rows[run.index / plan.seeds.get()].add(run);
        }
        let lines = results(&block, &plan.swept_keys()).to_csv();
        let head = lines.find('\n').map_or(0, |end| end + 1);
        csv += if first == 0 { &lines } else { &lines[head..] };
    }
    let path = sweep.join("results.csv");
    write_text(&path, &csv)?;
    let done: usize = rows.iter().map(|row| row.sample.len()).sum();
    Ok(Merged {
        results: path,
        table: trials(&rows),
        missing: plan.runs() - done,
        unreliable,
    })
}

impl<'p> MergedRun<'p> {
    fn read(sweep: &Path, plan: &'p Plan, index: usize) -> Result<Self> {
        let folder = plan.folder(sweep, index);
        let (trial, seed) = plan.parts(index);
        let is_done = folder.join(SUMMARY).exists();
        let summary = is_done.then(|| read_summary(&folder)).transpose()?;
        let is_other = |s: &&Summary| (&s.scene, s.seed) != (&trial.name, seed);
        if let Some(other) = summary.as_ref().filter(is_other) {
            return Err(Error::Usage(format!(
                "{}: this is the run of `{}` with the seed {}; move it elsewhere and repeat `{}`",
                folder.display(),
                other.scene,
                other.seed,
                command("sweep run")
            )));
        }
        Ok(Self {
            index,
            trial,
            seed,
            state: match is_done {
                true => "done",
                false if plan.is_over(sweep, index) => "diverged",
                false => "unfinished",
            },
            summary,
        })
    }
}

/// The table with a row for each run and a column for each key that the sweep varies.
fn results(runs: &[MergedRun], keys: &[&str]) -> Table {
    Table::of("", "", runs)
        .column("index", "", |run| run.index)
        .column("trial", "", |run| &run.trial.name[..])
        .columns(keys, "", |run, k| swept(run.trial.swept.get(keys[k])))
        .column("seed", "", |run| Cell::Count(run.seed))
        .column("state", "", |run| run.state)
        .column("iterations", "", |run| match &run.summary {
            Some(summary) => summary.iterations.into(),
            None => Cell::Missing,
        })
        .keyed(|run| run.summary.as_ref())
        .column("reliability", "", |run| {
            run.summary.as_ref().map(|s| s.reliability.word())
        })
        .done()
}

/// Converts the value of a key that the sweep varies into a cell of the table.
fn swept(value: Option<&Value>) -> Cell {
    match value {
        None => Cell::Missing,
        Some(Value::Number(number)) => number.as_f64().into(),
        Some(Value::String(text)) => text[..].into(),
        Some(other) => other.to_string().into(),
    }
}

/// The text for a missing number in the table of trials.
const MISSING: &str = "\u{2013}";

/// A trial and the results of its finished runs.
struct Row<'p> {
    trial: &'p Trial,
    /// The median displacement of robots that vary a little, in metres, for each finished run. This is the number to
    /// quote for a run. NaN stands for a diverged run.
    sample: Vec<f64>,
    reliable: usize,
    /// The number of robots that should walk far but stay in place.
    in_place: usize,
    seconds: Vec<f64>,
}

impl<'p> Row<'p> {
    fn new(trial: &'p Trial) -> Self {
        Self {
            trial,
            sample: Vec::new(),
            reliable: 0,
            in_place: 0,
            seconds: Vec::new(),
        }
    }

    fn add(&mut self, run: &MergedRun) {
        if let Some(summary) = &run.summary {
            let displacement = summary.displacement_robust_p50;
            self.sample.push(displacement.unwrap_or(f64::NAN));
            self.reliable += usize::from(!summary.is_unreliable());
            self.in_place += usize::from(summary.reliability.stays_in_place());
            self.seconds.push(summary.seconds);
        } else if run.state == "diverged" {
            self.sample.push(f64::NAN);
        }
    }

    fn statistics(&self) -> Statistics {
        Statistics::of(&self.sample)
    }
}

/// The table with a row for each trial. Columns about published numbers are left out if no trial has
/// one, and the column of robots that stay in place if there are none.
fn trials(rows: &[Row]) -> Table {
    let rows: Vec<(&Row, Statistics)> = rows.iter().map(|row| (row, row.statistics())).collect();
    let published = |(row, _): &(&Row, Statistics)| row.trial.published;
    let over_published = |row: &(&Row, Statistics)| ratio(row.1.median, published(row));
    let has_published = rows.iter().any(|row| published(row).is_some());
    let mut table = Table::of("trials", "", &rows);
    table = table.column("trial", "", |(row, _)| &row.trial.title[..]);
    if rows.iter().any(|(row, _)| row.in_place > 0) {
        table = table.column("stay in place", "", |(row, _)| row.in_place);
    }
    if has_published {
        table = table.column("published", "", published);
    }
    table = table.columns(["median", "±"], "", |(_, s), k| {
        [s.median, s.standard_error][k]
    });
    if has_published {
        table = table.column("median / published", "", over_published);
    }
    let seconds = Column::new("seconds", "").decimals(1, MISSING);
    table
        .columns(["p10", "p90", "best"], "", |(_, s), k| {
            [s.p10, s.p90, s.best][k]
        })
        .decimals(2, MISSING)
        .column("runs", "", |(row, _)| row.sample.len())
        .column("reliable", "", |(row, _)| row.reliable)
        .add(seconds, |(row, _)| {
            (!row.seconds.is_empty()).then(|| Quantiles::of(&row.seconds).p50)
        })
        .done()
}
