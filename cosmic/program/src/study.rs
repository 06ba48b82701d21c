//! `cosmic study`.

use crate::arguments::{Work, count, seed};
use crate::interrupt::Interrupt;
use crate::output::{answer_planned, answer_written};
use crate::progress::Many;
use clap::Args;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::scene::Scene;
use cosmic_lab::study::{Base, Study, StudyFile};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Run the experiments of a study file and compare their results with published numbers
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A TOML file, or `paper`, `ablation`, `findings` or `transfer`
    #[arg(value_name = "FILE")]
    file: String,
    /// Seeds per trial [default: as in the file, or 16]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    seeds: Option<NonZeroUsize>,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    first_seed: u64,
    /// Folder for the results; results of fewer seeds in it are replaced [default: the folder of the runs]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder for the runs, in which an interrupted study continues [default: runs/study-NAME]
    #[arg(long, value_name = "DIR")]
    runs: Option<PathBuf>,
    /// Only write the plan, into the folder S; then `sweep run S` does the runs, and `study ... --runs S` writes the
    /// results
    #[arg(long, value_name = "S", conflicts_with_all = ["runs", "out", "threads"])]
    plan: Option<PathBuf>,
    /// Fit the phases of every trial into this many iterations, to try the study quickly
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<NonZeroUsize>,
    /// A TOML file with settings for every built-in scene; the settings of the study override them
    #[arg(long, value_name = "FILE")]
    base: Option<PathBuf>,
    /// A Python with the packages mujoco and numpy, for studies with the key `mujoco`
    #[arg(long, value_name = "PATH", default_value = "python3")]
    python: PathBuf,
    #[command(flatten)]
    work: Work,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let (file, output) = (StudyFile::load(&self.file)?, &self.work.output);
        let base = |path: &PathBuf| -> Result<Base> {
            let (file, text) = (path.display().to_string(), Scene::text(path)?);
            Ok(Base { file, text })
        };
        let usual = || Path::new("runs").join(format!("study-{}", file.name));
        let runs = self
            .plan
            .clone()
            .or(self.runs.clone())
            .unwrap_or_else(usual);
        let study = Study {
            first_seed: self.first_seed,
            seeds: self.seeds.unwrap_or(file.seeds()),
            iterations: self.iterations,
            base: self
                .base
                .as_ref()
                .map(base)
                .transpose()?
                .unwrap_or_default(),
            out: self.out.clone().unwrap_or_else(|| runs.clone()),
            runs,
            python: self.python.clone(),
            registry: registry.clone(),
            file,
        };
        if self.plan.is_some() {
            return answer_planned(output, &study.runs, study.prepare()?.runs());
        }
        study.check_results()?;
        let plan = study.prepare()?;
        let overseer = Many::new(
            output,
            Interrupt::listen(self.work.output.quiet)?,
            &plan,
            plan.over(&study.runs),
        );
        study.simulate(&plan, self.work.threads, &overseer)?;
        answer_written(output, &study.write()?)
    }
}
