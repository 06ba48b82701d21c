//! `cosmic sweep`.

use crate::arguments::{Output, Work, count, seed, whole};
use crate::cost::cost_of_sweep;
use crate::interrupt;
use crate::output::{answer, note};
use crate::progress::{FinishedRuns, Progress, title, told};
use clap::{Args, Subcommand};
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::numbers::counted;
use cosmic::parallel::pool;
use cosmic::record::MOST_RUNS;
use cosmic::record::run::claimed;
use cosmic::scene::BUILTIN;
use cosmic_lab::sweep::{self, Overrides, Plan, Sweep};
use serde_json::json;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Do many runs, in any number of processes, and make a table of the results
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Do or continue the runs of a sweep, one per core; when all are done, merge them
    ///
    /// Several processes may share the folder: each skips the runs that another one is doing. A run whose simulation
    /// diverges counts as done, with exit code 0.
    Run(Run),
    /// Write results.csv of all finished runs, and print a table of the trials
    Merge {
        /// The folder of the sweep
        #[arg(value_name = "S")]
        sweep: PathBuf,
        #[command(flatten)]
        output: Output,
    },
}

#[derive(Debug, Args)]
struct Run {
    /// A TOML file with [[trials]], or built-in scenes and scene files
    #[arg(value_name = "SPEC", default_value = BUILTIN[0].name)]
    spec: Vec<String>,
    /// Change a key of all scenes; several values, as in `--set physics.friction=0.6,1`, make a grid; can be repeated
    #[arg(long, value_name = "KEY=V,V...")]
    set: Vec<String>,
    /// Seeds per trial [default: as in the file, or 1]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    seeds: Option<NonZeroUsize>,
    /// The first seed [default: as in the file, or 0]
    #[arg(long, value_name = "N", value_parser = seed, allow_negative_numbers = true)]
    first_seed: Option<u64>,
    /// Fit the phases of every scene into this many iterations
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<NonZeroUsize>,
    /// The folder of the sweep; the same command continues it
    #[arg(long, value_name = "S")]
    out: PathBuf,
    /// Do only the run with this number, counted from 0: trial by trial, and within a trial seed by seed
    #[arg(long, value_name = "I", value_parser = index, allow_negative_numbers = true)]
    index: Option<usize>,
    #[command(flatten)]
    work: Work,
}

/// Parses the number of a run.
fn index(text: &str) -> std::result::Result<usize, String> {
    whole(0..=MOST_RUNS - 1)(text)
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        match &self.action {
            Action::Run(run) => run.run(registry),
            Action::Merge { sweep, output } => merge(sweep, output),
        }
    }
}

impl Run {
    fn run(&self, registry: &Registry) -> Result<()> {
        let overrides = Overrides {
            set: self.set.clone(),
            seeds: self.seeds,
            first_seed: self.first_seed,
            iterations: self.iterations,
        };
        let plan = &sweep::read(&self.spec, &overrides, registry)?;
        let (folder, output) = (&*self.out, &self.work.output);
        if let Some(index) = self.index {
            // A number that is too large is refused before anything is written.
            plan.run(index, registry)?;
        }
        plan.keep(folder, registry)?;
        let stop = interrupt::listen(output.quiet)?;
        let sweep = Sweep {
            folder,
            plan,
            registry,
        };
        match self.index {
            Some(index) => one(&sweep, index, stop, &self.work)?,
            None => {
                if !output.quiet {
                    self.announce(plan, registry)?;
                }
                let observer = FinishedRuns::new(output, stop, plan, folder);
                sweep.run_all(self.work.threads, &observer)?;
            }
        }
        let (left, total) = (plan.left(folder).count(), plan.runs());
        if left == 0 {
            return merge(folder, output);
        }
        if self.index.is_none() && !output.quiet {
            note(&format!("other processes are doing {left} of {total} runs"));
            for claimed in plan
                .left(folder)
                .filter_map(|index| claimed(&plan.folder(folder, index)))
            {
                note(&claimed.to_string());
            }
        }
        Ok(())
    }
}

/// The worlds of a sweep are compared if it has at most this many trials: each scene must be parsed for it.
const MOST_COMPARED: usize = 100;

impl Run {
    /// Says how many runs a sweep has, whether its worlds differ, and what the runs that are not done cost.
    fn announce(&self, plan: &Plan, registry: &Registry) -> Result<()> {
        let (trials, seeds) = (plan.trials.len(), plan.seeds.get());
        let left = plan.left(&self.out).count();
        if left == 0 {
            return Ok(());
        }
        note(&format!(
            "runs: {} ({} with {}), {} done",
            plan.runs(),
            counted(trials, "trial"),
            counted(seeds, "seed"),
            plan.runs() - left,
        ));
        let world = |trial| Ok(plan.run(trial * seeds, registry)?.scene.describe_world());
        let compared = if trials > MOST_COMPARED { 0 } else { trials };
        let worlds: BTreeSet<String> = (0..compared).map(world).collect::<Result<_>>()?;
        if worlds.len() > 1 {
            let count = worlds.len();
            note(&format!(
                "worlds: the trials are in {count} different worlds"
            ));
        }
        // A run that cannot be measured fails alone, when its turn comes.
        if let Ok(cost) = cost_of_sweep(plan, left, registry) {
            note(&format!("cost: {cost}"));
        }
        Ok(())
    }
}

fn one(sweep: &Sweep, index: usize, stop: Arc<AtomicBool>, work: &Work) -> Result<()> {
    let pool = pool(work.threads)?;
    let mut progress = Progress::new(&work.output, stop, Vec::new());
    let outcome = pool.install(|| sweep.run_one(index, &mut progress));
    drop(progress);
    let (title, says) = (title(sweep.plan, index), told(&outcome?));
    note(&format!("run {index}, {title}: {says}"));
    Ok(())
}

/// At most this many unreliable runs are named below a table.
const MOST_NAMED: usize = 10;

fn merge(sweep: &Path, output: &Output) -> Result<()> {
    let merged = sweep::merge(sweep)?;
    let (results, missing) = (merged.results.display(), merged.missing);
    if missing > 0 {
        note(&format!("{missing} runs are not done"));
    }
    let unreliable = match &merged.unreliable[..] {
        [] => String::new(),
        runs => {
            let (named, others) = runs.split_at(MOST_NAMED.min(runs.len()));
            let more = match others.len() {
                0 => String::new(),
                count => format!(" and {count} more"),
            };
            format!("unreliable: {}{more}\n", named.join(", "))
        }
    };
    let rows = merged.table.to_json()["rows"].take();
    let value = json!({ "results": results.to_string(), "missing": missing, "trials": rows, "unreliable": merged.unreliable });
    answer(
        output,
        &value,
        &format!("{}{unreliable}{results}\n", merged.table.to_text()),
    )
}
