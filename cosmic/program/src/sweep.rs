//! `cosmic sweep`.

use crate::arguments::{Output, Settings, Work, count, seed};
use crate::interrupt::Interrupt;
use crate::output::{answer, counted, in_json, lines, note, print, print_json};
use crate::progress::{Many, Progress, title, told};
use crate::source::name_of;
use clap::{Args, Subcommand};
use cosmic::error::{Error, Result};
use cosmic::scene;
use cosmic_lab::sweep::{
    Ended, MergedRun, PlannedScene, RunOutcome, RunState, Sweep, SweepPlan, merge, survey,
    write_results,
};
use serde_json::json;
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::thread;
use std::time::Duration;

/// Many runs from a frozen plan, shared by any number of processes
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Fix scenes and seeds in a new folder
    Plan(Plan),
    /// Do the runs that are not done, or go on with them, until none is left
    ///
    /// A run whose simulation diverges is done as well, with exit code 0: that is its result, which
    /// `status` and `merge` give.
    Run {
        /// The sweep's folder
        #[arg(value_name = "S")]
        sweep: PathBuf,
        /// A run's number, `auto` for the next that nobody has taken, `all` for all of those
        #[arg(long, value_name = "I", default_value = "all")]
        index: Index,
        #[command(flatten)]
        work: Work,
    },
    /// Say how far every run is
    Status {
        /// The sweep's folder
        #[arg(value_name = "S")]
        sweep: PathBuf,
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
    /// Write results.json and results.csv from the runs that are done
    Merge {
        /// The sweep's folder
        #[arg(value_name = "S")]
        sweep: PathBuf,
        #[command(flatten)]
        output: Output,
    },
}

#[derive(Debug, Args)]
struct Plan {
    /// Built-in scenes or TOML files
    #[arg(value_name = "SCENE", default_value = scene::all()[0].name)]
    scenes: Vec<String>,
    #[command(flatten)]
    settings: Settings,
    /// Seeds per scene
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    seeds: NonZeroUsize,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    first_seed: u64,
    /// Stop every run after this many iterations
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<NonZeroUsize>,
    /// The sweep's folder, new or empty
    #[arg(long, value_name = "S")]
    out: PathBuf,
    #[command(flatten)]
    output: Output,
}

/// Which run.
#[derive(Debug, Clone, Copy)]
enum Index {
    Number(usize),
    Auto,
    All,
}

impl FromStr for Index {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text {
            "auto" => Ok(Index::Auto),
            "all" => Ok(Index::All),
            number => match number.parse() {
                Ok(number) => Ok(Index::Number(number)),
                Err(_) => Err("a run's number, `auto` or `all`".to_owned()),
            },
        }
    }
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        match &self.action {
            Action::Plan(plan) => plan.freeze(),
            Action::Run { sweep, index, work } => run(sweep, *index, work),
            Action::Status { sweep, json } => status(sweep, *json),
            Action::Merge { sweep, output } => merge_sweep(sweep, output),
        }
    }
}

impl Plan {
    fn freeze(&self) -> Result<()> {
        let planned = |scene: &String| {
            Ok(PlannedScene {
                name: name_of(Path::new(scene)),
                scene: self.settings.load(scene)?,
            })
        };
        let plan = SweepPlan {
            scenes: self.scenes.iter().map(planned).collect::<Result<_>>()?,
            first_seed: self.first_seed,
            seeds: self.seeds,
            iterations: self.iterations,
        };
        plan.freeze(&self.out)?;
        let (sweep, runs) = (self.out.display(), plan.runs());
        let value = json!({ "sweep": sweep.to_string(), "runs": runs });
        let text = format!("{sweep}: {}\n", counted(runs, "run"));
        answer(&self.output, &value, &text)
    }
}

fn run(folder: &Path, index: Index, Work { threads, output }: &Work) -> Result<()> {
    let plan = &SweepPlan::read(folder)?;
    let sweep = Sweep { folder, plan };
    if let Index::All = index {
        return run_all(sweep, *threads, output);
    }
    let runs = plan.runs();
    let pool = crate::runs::pool(*threads)?;
    let interrupt = Interrupt::listen()?;
    let mut progress = Progress::new(output, interrupt.clone());
    let mut once = || match index {
        Index::Number(index) if index >= runs => Err(Error::Usage(format!(
            "there is no run {index}: the plan has {runs}, from 0 on"
        ))),
        Index::Number(index) => {
            let outcome = sweep.run_one(index, &mut progress)?;
            Ok(Some(Ended { index, outcome }))
        }
        _ => sweep.run_next(&mut progress),
    };
    let ended = loop {
        match pool.install(&mut once) {
            // Whether the holder on another host lives is told by waiting.
            Ok(Some(ended)) if ended.outcome == RunOutcome::Watched => {
                if interrupt.is_asked() {
                    let (done, total) = (plan.over(folder), runs);
                    break Err(Error::Stopped { done, total });
                }
                thread::sleep(Duration::from_secs(1));
            }
            ended => break ended,
        }
    };
    drop(progress);
    match ended? {
        Some(Ended { index, outcome }) if outcome == RunOutcome::Taken => {
            Err(Error::Usage(format!("run {index} {}", told(&outcome))))
        }
        ended => show(plan, ended, output),
    }
}

fn run_all(sweep: Sweep, threads: Option<NonZeroUsize>, output: &Output) -> Result<()> {
    let Sweep { folder, plan } = sweep;
    let overseer = Many::new(output, plan, plan.over(folder))?;
    sweep.run_all(threads, &overseer)?;
    drop(overseer);
    let total = plan.runs();
    let left = total - plan.over(folder);
    if left > 0 && !output.quiet {
        note(&format!(
            "{left} of {total} runs are at work in other processes"
        ));
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
        None => print("nothing is left to take\n"),
        Some(Ended { index, outcome }) => {
            let (title, says) = (title(plan, index), told(&outcome));
            print(&format!("run {index}, {title}: {says}\n"))
        }
    }
}

fn status(sweep: &Path, as_json: bool) -> Result<()> {
    let plan = SweepPlan::read(sweep)?;
    let merged = survey(sweep, &plan);
    if as_json {
        let count = |state: RunState| (state.name(), merged.count(state));
        let counts = BTreeMap::from(RunState::ALL.map(count));
        let run = |run: &MergedRun| {
            json!({ "index": run.index, "scene": run.scene, "seed": run.seed,
                    "state": run.state, "iterations": run.iterations })
        };
        let runs: Vec<_> = merged.runs.iter().map(run).collect();
        return print_json(&json!({ "runs": runs, "counts": counts }));
    }
    let widths = merged.runs.iter().map(|run| run.scene.chars().count());
    let width = widths.max().unwrap_or(0);
    let line = |run: &MergedRun| {
        let (index, scene, seed) = (run.index, &run.scene, run.seed);
        let (state, done) = (run.state.name(), counted(run.iterations, "iteration"));
        format!("{index:5}  {scene:width$}  seed {seed:<5}  {state:8}  {done}\n")
    };
    let lines: String = merged.runs.iter().map(line).collect();
    let counts = RunState::ALL.map(|state| format!("{} {}", merged.count(state), state.name()));
    print(&format!("{lines}{}\n", counts.join(", ")))
}

fn merge_sweep(sweep: &Path, output: &Output) -> Result<()> {
    let plan = SweepPlan::read(sweep)?;
    let merged = merge(sweep, &plan)?;
    let written = write_results(sweep, &merged)?;
    let missing = merged.left();
    if missing > 0 && !output.quiet {
        note(&format!("{missing} of {} runs are not done", plan.runs()));
    }
    let value = json!({ "written": in_json(&written), "missing": missing });
    answer(output, &value, &lines(&written))
}
