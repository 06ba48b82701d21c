//! The paper's evaluation again: many seeds of every experiment, laid beside the paper's numbers.
//!
//! A [`Study`] is a sweep with a document. [`prepare`](Study::prepare) freezes its plan,
//! [`simulate`](Study::simulate) does what is left of the runs and measures each delivered design
//! at half the time step and with the goal behind, [`write`](Study::write) reads the records and
//! writes Markdown, CSV, JSON and figures. Every number of these follows from the plan, wall times
//! aside.

mod ablation;
mod check;
mod figures;
mod files;
mod findings;
mod markdown;
mod motifs;
mod paper;
mod rows;
mod statistics;
mod trials;

pub use check::Check;
pub use motifs::MotifRow;
pub use rows::{Row, RunRow};
pub use statistics::Statistics;
pub use trials::{Base, Entities, Kind, Trial, trials};

use crate::sweep::{Overseer, PLAN, PlannedScene, RunState, SweepPlan, run_all};
use check::with_half_steps;
use cosmic::error::{Error, Result, in_shell};
use cosmic::parallel::{Crew, in_parallel};
use cosmic::record::files::make_folder;
use rows::collect;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use trials::NO_BASE;

/// What is to be studied, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Which study.
    pub kind: Kind,
    /// The first seed.
    pub first_seed: u64,
    /// How many seeds, from the first on.
    pub seeds: NonZeroUsize,
    /// Stop every run after so many iterations: to try a study in little.
    pub iterations: Option<NonZeroUsize>,
    /// A file's name and text: settings under those of every scene.
    pub base: Option<(String, String)>,
    /// Where the results go.
    pub out: PathBuf,
    /// Where the runs are, or go on.
    pub runs: PathBuf,
}

/// Where results go, unless another folder is named.
pub const RESULTS: &str = "docs/results";

/// Where the runs of a study are, unless another folder is named.
pub fn runs_of(kind: Kind) -> PathBuf {
    PathBuf::from("runs").join(format!("study-{}", kind.name()))
}

impl Study {
    /// The experiments.
    ///
    /// # Errors
    /// Those of [`trials`].
    pub fn trials(&self) -> Result<Vec<Trial>> {
        let base = self.base.as_ref();
        let base = base.map_or(NO_BASE, |(file, text)| Base { file, text });
        trials(self.kind, &base)
    }

    /// Every experiment with every seed.
    ///
    /// # Errors
    /// Those of [`trials`].
    pub fn plan(&self) -> Result<SweepPlan> {
        let scene = |trial: Trial| PlannedScene {
            name: trial.name,
            scene: trial.scene,
        };
        Ok(SweepPlan {
            scenes: self.trials()?.into_iter().map(scene).collect(),
            first_seed: self.first_seed,
            seeds: self.seeds,
            iterations: self.iterations,
        })
    }

    /// Freezes the plan, or finds it frozen by a study that goes on. Other seeds of the same
    /// experiments may join those that are there.
    ///
    /// # Errors
    /// [`Error::Usage`] where the runs are of other experiments; those of [`SweepPlan::freeze`].
    pub fn prepare(&self) -> Result<SweepPlan> {
        let plan = self.plan()?;
        for PlannedScene { name, scene } in &plan.scenes {
            with_half_steps(scene).check().map_err(|error| {
                Error::Usage(format!(
                    "{name}: its designs are rolled out with half the time step and twice the \
                     steps as well, which no scene may have: {}",
                    error.within()
                ))
            })?;
        }
        // Before hours of work that could not be written down.
        make_folder(&self.out)?;
        if !self.runs.join(PLAN).exists() {
            plan.freeze(&self.runs)?;
            return Ok(plan);
        }
        let before = SweepPlan::read(&self.runs)?;
        if (&before.scenes, before.iterations) != (&plan.scenes, plan.iterations) {
            let runs = self.runs.display();
            return Err(Error::Usage(format!(
                "{runs}: the runs there are of other scenes or another number of iterations; name \
                 another folder by --runs"
            )));
        }
        if before != plan {
            plan.check()?;
            plan.write(&self.runs)?;
        }
        Ok(plan)
    }

    /// Does what is left of the runs, one a thread, and measures the delivered designs.
    ///
    /// # Errors
    /// Those of [`run_all`] and [`Check::keep`]; [`Error::Usage`] where other processes are still
    /// at work on some.
    pub fn simulate(
        &self,
        plan: &SweepPlan,
        threads: Option<NonZeroUsize>,
        overseer: &dyn Overseer,
    ) -> Result<()> {
        run_all((&self.runs, plan), threads, overseer)?;
        let left = plan.runs() - plan.over(&self.runs);
        if left > 0 {
            return Err(Error::Usage(format!(
                "other processes are at work on {left} runs; the same command goes on when they \
                 are done"
            )));
        }
        let total = plan.runs();
        let checked = in_parallel(total, Crew::of_one(threads), |index, _| {
            if overseer.is_stopped() {
                return Err(Error::Stopped { done: total, total });
            }
            let folder = plan.folder(&self.runs, index);
            match RunState::of(&folder) {
                RunState::Done => Check::keep(&folder),
                _ => Ok(()),
            }
        });
        checked.map(drop)
    }

    /// Writes the results from the runs' records, and says which files these are.
    ///
    /// # Errors
    /// Where a record is missing or no good, or a file cannot be written.
    pub fn write(&self) -> Result<Vec<PathBuf>> {
        let collected = collect(&self.runs, &self.plan()?, &self.trials()?)?;
        let mut written = figures::write(self, &collected)?;
        let motifs = motifs::count(&collected)?;
        let rows = collected.into_iter().map(|trial| trial.row).collect();
        let mut results = files::Results::of_rows(self, rows);
        results.motifs = motifs;
        let document = match self.kind {
            Kind::Paper => paper::document(self, &results),
            Kind::Ablation => ablation::document(self, &results),
            Kind::Findings => findings::document(self, &results),
        };
        written.extend(files::write(self, &results, &document)?);
        Ok(written)
    }

    /// The commands that make these results, as a user writes them.
    fn commands(&self) -> String {
        let mut command = format!("cosmic study {} --seeds {}", self.kind.name(), self.seeds);
        if self.first_seed != 0 {
            command += &format!(" --first-seed {}", self.first_seed);
        }
        if let Some(iterations) = self.iterations {
            command += &format!(" --iterations {iterations}");
        }
        if let Some((file, _)) = &self.base {
            command += &format!(" --base {}", in_shell(Path::new(file)));
        }
        let folders = [
            ("out", &self.out, RESULTS.into()),
            ("runs", &self.runs, runs_of(self.kind)),
        ];
        for (option, folder, usual) in folders {
            if *folder != usual {
                command += &format!(" --{option} {}", in_shell(folder));
            }
        }
        command
    }
}
