//! Writes `results.json` and `results.csv`: the results of all runs, read from their folders.

use super::state::iterations;
use super::{RunState, SweepPlan};
use crate::files::write_text;
use crate::table::{Cell, Table};
use cosmic::error::Result;
use cosmic::keys::{Keyed, columns};
use cosmic::record::Summary;
use cosmic::record::files::{Format, write_json};
use rayon::prelude::*;
use serde::ser::{Error as _, SerializeSeq};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};
use std::cell::RefCell;
use std::path::{Path, PathBuf};

/// The format of merged results.
pub(super) const FORMAT: Format = Format {
    name: "cosmic-sweep-results",
    version: 1,
};

/// The progress of one run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SurveyedRun {
    /// The run's number in the plan.
    pub index: usize,
    /// The name of the run's scene.
    pub scene: String,
    /// For each key that the sweep varies, the value in this run; empty if the sweep has no grid.
    pub swept: Map<String, Value>,
    /// The run's seed.
    pub seed: u64,
    /// The run's state.
    pub state: RunState,
    /// The number of iterations that the run has done.
    pub iterations: usize,
}

/// The progress of a sweep's runs, in the plan's order.
#[derive(Clone, Debug, PartialEq)]
pub struct Survey {
    /// One entry per run.
    pub runs: Vec<SurveyedRun>,
}

impl Survey {
    /// The number of runs in a state.
    pub fn count(&self, state: RunState) -> usize {
        self.runs.iter().filter(|run| run.state == state).count()
    }

    /// The numbers of all runs that are not finished.
    pub fn left(&self) -> Vec<usize> {
        let left = self.runs.iter().filter(|run| !run.state.is_over());
        left.map(|run| run.index).collect()
    }
}

/// Reads the progress of a sweep's runs.
pub fn survey(sweep: &Path, plan: &SweepPlan) -> Survey {
    let one = |index: usize| {
        let folder = plan.folder(sweep, index);
        let state = RunState::of(&folder);
        SurveyedRun::new(plan, index, state, iterations(&folder, state))
    };
    let runs = (0..plan.runs()).into_par_iter().map(one).collect();
    Survey { runs }
}

impl SurveyedRun {
    fn new(plan: &SweepPlan, index: usize, state: RunState, iterations: usize) -> Self {
        let (scene, seed) = plan.parts(index);
        let swept = scene.swept.iter().cloned();
        Self {
            index,
            scene: scene.name.clone(),
            swept: swept.map(|swept| (swept.key, swept.value)).collect(),
            seed,
            state,
            iterations,
        }
    }
}

/// The result of one run, with the keys that it has in `results.json`.
#[derive(Serialize)]
struct MergedRun {
    #[serde(flatten)]
    run: SurveyedRun,
    /// The run's summary, if the run is done.
    summary: Option<Summary>,
}

/// The paths of the merged results, and the number of runs whose results are missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// The path of all results, a JSON file.
    pub results: PathBuf,
    /// The path of the table of results, a CSV file.
    pub table: PathBuf,
    /// The number of unfinished runs.
    pub missing: usize,
}

/// Writes the results of a sweep into its folder. Summaries are read and written in blocks, so that the memory does not
/// grow with the number of runs.
///
/// # Errors
/// The errors of [`Summary::read`]; [`Error::Write`](cosmic::Error::Write).
pub fn merge(sweep: &Path, plan: &SweepPlan) -> Result<Merged> {
    let [json, csv] = ["results.json", "results.csv"].map(|name| sweep.join(name));
    let progress = RefCell::new(Progress {
        missing: 0,
        table: String::new(),
        failed: None,
    });
    let results = Results {
        runs: Runs {
            sweep,
            plan,
            keys: &plan.swept_keys(),
            progress: &progress,
        },
    };
    let done = write_json(&json, FORMAT, &results);
    let Progress {
        missing,
        table,
        failed,
    } = progress.into_inner();
    // If a run could not be read, `write_json` fails too. Report the cause, not the failed write.
    failed.map_or(done, Err)?;
    write_text(&csv, &table)?;
    Ok(Merged {
        results: json,
        table: csv,
        missing,
    })
}

/// The progress of writing `results.json`. It also collects the text of the CSV file, so that every summary is read
/// only once.
struct Progress {
    missing: usize,
    /// The text of `results.csv` so far.
    table: String,
    failed: Option<cosmic::Error>,
}

/// The content of `results.json`. Each run is read from its folder when it is written.
#[derive(Serialize)]
struct Results<'p> {
    runs: Runs<'p>,
}

struct Runs<'p> {
    sweep: &'p Path,
    plan: &'p SweepPlan,
    keys: &'p [&'p str],
    progress: &'p RefCell<Progress>,
}

/// Results are read and written in blocks. This is the number of runs in a block.
const AT_ONCE: usize = 256;

impl Runs<'_> {
    /// Reads the block of runs that begins with number `first`.
    fn read(&self, first: usize) -> Result<Vec<MergedRun>> {
        let (sweep, plan) = (self.sweep, self.plan);
        let last = plan.runs().min(first + AT_ONCE);
        let read = |index: usize| {
            let folder = plan.folder(sweep, index);
            let state = RunState::of(&folder);
            let is_done = state == RunState::Done;
            let summary = is_done.then(|| Summary::read(&folder)).transpose()?;
            let done = summary.as_ref().map(|summary| summary.iterations);
            let iterations = done.unwrap_or_else(|| iterations(&folder, state));
            let run = SurveyedRun::new(plan, index, state, iterations);
            Ok(MergedRun { run, summary })
        };
        (first..last).into_par_iter().map(read).collect()
    }
}

impl Serialize for Runs<'_> {
    fn serialize<T: Serializer>(&self, to: T) -> std::result::Result<T::Ok, T::Error> {
        let runs = self.plan.runs();
        let mut list = to.serialize_seq(Some(runs))?;
        for first in (0..runs).step_by(AT_ONCE) {
            let mut progress = self.progress.borrow_mut();
            match self.read(first) {
                Ok(merged) => {
                    merged
                        .iter()
                        .try_for_each(|run| list.serialize_element(run))?;
                    progress.add(&merged, self.keys);
                }
                Err(error) => {
                    progress.failed = Some(error);
                    return Err(T::Error::custom("a run cannot be read"));
                }
            }
        }
        list.end()
    }
}

impl Progress {
    fn add(&mut self, merged: &[MergedRun], keys: &[&str]) {
        let left = merged.iter().filter(|merged| !merged.run.state.is_over());
        self.missing += left.count();
        let rows = table(merged, keys).to_csv();
        let head = rows.find('\n').map_or(0, |end| end + 1);
        self.table += if self.table.is_empty() {
            &rows
        } else {
            &rows[head..]
        };
    }
}

/// A row of the table of results: a run with the numbers of its summary.
struct Row<'r> {
    run: &'r SurveyedRun,
    /// The numbers of the run's summary; empty if the run is not done.
    numbers: Vec<Option<f64>>,
    verdict: Option<&'static str>,
}

impl<'r> Row<'r> {
    fn of(MergedRun { run, summary }: &'r MergedRun) -> Self {
        Self {
            run,
            numbers: summary.as_ref().map_or_else(Vec::new, Keyed::numbers),
            verdict: summary.as_ref().and_then(Summary::verdict),
        }
    }
}

/// The table with a row for each run and a column for each key that the sweep varies. Cells of missing numbers are
/// empty.
fn table(runs: &[MergedRun], keys: &[&str]) -> Table {
    let names = columns(&Summary::keys());
    let rows: Vec<Row> = runs.iter().map(Row::of).collect();
    Table::of("", "", &rows)
        .column("index", "", |row| row.run.index)
        .column("scene", "", |row| &row.run.scene[..])
        .columns(keys, "", |row, k| swept(row.run.swept.get(keys[k])))
        .column("seed", "", |row| Cell::Count(row.run.seed))
        .column("state", "", |row| row.run.state.name())
        .column("iterations", "", |row| row.run.iterations)
        .columns(names, "", |row, k| row.numbers.get(k).copied().flatten())
        .column("reliability", "", |row| row.verdict)
        .decimals(3, "-")
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
