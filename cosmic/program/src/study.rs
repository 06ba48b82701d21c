//! `cosmic study`.

use crate::arguments::{Work, count, seed};
use crate::interrupt::Interrupt;
use crate::output::{answer_planned, answer_written};
use crate::progress::Many;
use clap::{Args, Subcommand};
use cosmic::error::Result;
use cosmic::scene::Scene;
use cosmic_lab::study::{Base, Study, StudyKind};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// The paper's evaluation again, beside the paper's numbers
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    kind: Which,
}

#[derive(Debug, Subcommand)]
enum Which {
    /// Every design and environment of the paper, strictly by its algorithm and by default
    Paper(Options),
    /// Topology, material and control, each designed or not: eight trials
    Ablation(Options),
    /// The paper's findings, by one change of the default at a time
    Findings(Options),
    /// Designs in another simulator, MuJoCo, on grounds of several frictions
    Transfer(TransferOptions),
}

#[derive(Debug, Args)]
struct TransferOptions {
    #[command(flatten)]
    options: Options,
    /// A Python that has the packages mujoco and numpy
    #[arg(long, value_name = "PATH", default_value = PYTHON)]
    python: PathBuf,
}

const PYTHON: &str = "python3";

#[derive(Debug, Args)]
struct Options {
    /// Seeds per experiment
    #[arg(long, value_name = "N", default_value = "16", value_parser = count, allow_negative_numbers = true)]
    seeds: NonZeroUsize,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    first_seed: u64,
    /// Folder for the results, without any or with those of fewer seeds [default: that of the runs]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder for the runs; an interrupted study goes on there [default: runs/study-NAME]
    #[arg(long, value_name = "DIR")]
    runs: Option<PathBuf>,
    /// Freeze the plan in folder S and end; `sweep run S` does the runs, `study ... --runs S` the rest
    #[arg(long, value_name = "S", conflicts_with_all = ["runs", "out", "threads"])]
    plan: Option<PathBuf>,
    /// Stop every run after this many iterations, to try a study in little
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<NonZeroUsize>,
    /// A TOML file of settings under those of every experiment
    #[arg(long, value_name = "FILE")]
    base: Option<PathBuf>,
    #[command(flatten)]
    work: Work,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let (kind, options, python) = match &self.kind {
            Which::Paper(options) => (StudyKind::Paper, options, Path::new(PYTHON)),
            Which::Ablation(options) => (StudyKind::Ablation, options, Path::new(PYTHON)),
            Which::Findings(options) => (StudyKind::Findings, options, Path::new(PYTHON)),
            Which::Transfer(TransferOptions { options, python }) => {
                (StudyKind::Transfer, options, &**python)
            }
        };
        let base = match &options.base {
            None => Base::default(),
            Some(path) => Base {
                file: path.display().to_string(),
                text: Scene::text(path)?,
            },
        };
        let folder = options.plan.as_ref().or(options.runs.as_ref());
        let runs = folder.cloned().unwrap_or_else(|| kind.folder());
        let study = Study {
            kind,
            first_seed: options.first_seed,
            seeds: options.seeds,
            iterations: options.iterations,
            base,
            out: options.out.clone().unwrap_or_else(|| runs.clone()),
            runs,
            python: python.to_owned(),
        };
        if options.plan.is_some() {
            let runs = study.plan_runs()?.runs();
            return answer_planned(&options.work.output, &study.runs, runs);
        }
        let plan = study.prepare()?;
        let (output, over) = (&options.work.output, plan.over(&study.runs));
        let overseer = Many::new(output, Interrupt::listen()?, &plan, over);
        study.simulate(&plan, options.work.threads, &overseer)?;
        let written = study.write()?;
        answer_written(output, &written)
    }
}
