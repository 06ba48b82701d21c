//! `cosmic sweep run`.

use super::status::status;
use crate::arguments::{Output, Work};
use crate::interrupt::Interrupt;
use crate::output::{note, print, print_json};
use crate::progress::{Many, Progress, title, told};
use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic_lab::sweep::{Ended, RunOutcome, RunState, Sweep, SweepPlan, parse_ranges};
use serde_json::json;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::str::FromStr;

#[derive(Debug, Args)]
pub(super) struct Run {
    /// The folder of the sweep
    #[arg(value_name = "S")]
    sweep: PathBuf,
    /// The number of a run, several numbers such as `3-17,40`, `auto` for the next free run, or `all`
    #[arg(long, value_name = "I", default_value = "all")]
    index: Index,
    #[command(flatten)]
    work: Work,
}

/// The runs that the user asks for.
#[derive(Debug, Clone)]
enum Index {
    Number(usize),
    Several(Vec<RangeInclusive<usize>>),
    Auto,
    All,
}

impl FromStr for Index {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match (text, text.parse(), parse_ranges(text)) {
            ("auto", ..) => Ok(Index::Auto),
            ("all", ..) => Ok(Index::All),
            (_, Ok(number), _) => Ok(Index::Number(number)),
            (_, _, Some(several)) => Ok(Index::Several(several)),
            _ => Err(
                "expected the number of a run, several numbers such as 3-17,40, `auto` or `all`"
                    .to_owned(),
            ),
        }
    }
}

impl Run {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let folder = &self.sweep;
        let plan = &SweepPlan::read(folder)?;
        let runs = self.index.runs(plan.runs())?;
        let interrupt = Interrupt::listen(self.work.output.quiet)?;
        if let Some(study) = &plan.study {
            study.check()?;
        }
        let sweep = Sweep {
            folder,
            plan,
            registry,
        };
        match (&self.index, &runs[..]) {
            (Index::Auto, _) => one(&sweep, None, interrupt, &self.work),
            (Index::Number(_), [index]) => one(&sweep, Some(*index), interrupt, &self.work),
            _ => several(&sweep, &runs, interrupt, &self.work),
        }
    }
}

impl Index {
    /// Returns the numbers of the requested runs, in ascending order and without repetition. The plan has `count` runs.
    fn runs(&self, count: usize) -> Result<Vec<usize>> {
        let all = [0..=count.saturating_sub(1)];
        let ranges: &[RangeInclusive<usize>] = match self {
            Index::Number(index) => &[*index..=*index],
            Index::Several(ranges) => ranges,
            Index::Auto | Index::All => &all,
        };
        if let Some(index) = ranges
            .iter()
            .map(|range| *range.end())
            .find(|k| *k >= count)
        {
            return Err(Error::Usage(format!(
                "there is no run {index}: the plan has {count} runs, numbered from 0"
            )));
        }
        let mut runs: Vec<usize> = ranges.iter().cloned().flatten().collect();
        runs.sort_unstable();
        runs.dedup();
        Ok(runs)
    }
}

/// Does the run with number `index`, or the next free run if `index` is `None`.
fn one(sweep: &Sweep, index: Option<usize>, interrupt: Interrupt, work: &Work) -> Result<()> {
    let pool = crate::runs::pool(work.threads)?;
    let mut progress = Progress::new(&work.output, interrupt.clone(), Vec::new());
    let is_stopped = || interrupt.is_asked();
    let ended = pool.install(|| match index {
        None => sweep.run_next(&mut progress, &is_stopped),
        Some(index) => {
            let outcome = sweep.run_one(index, &mut progress, &is_stopped)?;
            Ok(Some(Ended { index, outcome }))
        }
    });
    drop(progress);
    match ended? {
        Some(Ended { index, outcome }) if outcome == RunOutcome::Taken => {
            Err(Error::Usage(format!("run {index} {}", told(&outcome))))
        }
        ended => show(sweep.plan, ended, &work.output),
    }
}

fn several(sweep: &Sweep, runs: &[usize], interrupt: Interrupt, work: &Work) -> Result<()> {
    let (plan, folder, output) = (sweep.plan, sweep.folder, &work.output);
    let overseer = Many::new(output, interrupt, plan, plan.over(folder));
    sweep.run_these(runs, work.threads, &overseer)?;
    drop(overseer);
    let is_left = |index: &&usize| !RunState::of(&plan.folder(folder, **index)).is_over();
    let (left, total) = (runs.iter().filter(is_left).count(), runs.len());
    if left > 0 && !output.quiet {
        note(&format!("other processes are doing {left} of {total} runs"));
    }
    if output.json {
        return status(folder, true);
    }
    Ok(())
}

fn show(plan: &SweepPlan, ended: Option<Ended>, output: &Output) -> Result<()> {
    if output.json {
        let index = ended.as_ref().map(|ended| ended.index);
        let says = ended.as_ref().map(|ended| told(&ended.outcome));
        return print_json(&json!({ "index": index, "says": says }));
    }
    match ended {
        _ if output.quiet => Ok(()),
        None => print("each run is finished or is being done by another process\n"),
        Some(Ended { index, outcome }) => {
            let (title, says) = (title(plan, index), told(&outcome));
            print(&format!("run {index}, {title}: {says}\n"))
        }
    }
}
