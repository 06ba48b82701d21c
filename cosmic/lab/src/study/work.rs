//! The steps of a study: plan, runs, results.

use super::file::{Base, StudyFile, Trial};
use super::tables::{Run, TrialRow};
use crate::measure::{Errands, numbers};
use crate::sweep::{Overseer, PLAN, PlannedScene, PlannedStudy, RunState, Sweep, SweepPlan};
use cosmic::Registry;
use cosmic::error::{Error, Result, in_shell};
use cosmic::lattice::Lattice;
use cosmic::record::files::make_folder;
use cosmic::scene::{GoalKind, Scene};
use std::num::NonZeroUsize;
use std::path::PathBuf;

/// A study and its folders.
#[derive(Clone, Debug)]
pub struct Study {
    /// The experiments.
    pub file: StudyFile,
    /// The first seed.
    pub first_seed: u64,
    /// The number of consecutive seeds.
    pub seeds: NonZeroUsize,
    /// If set, the phases of every trial are fitted into this many iterations, to try the study quickly.
    pub iterations: Option<NonZeroUsize>,
    /// A user's settings that replace the defaults of every built-in scene; see [`Base`].
    pub base: Base,
    /// The folder of the results.
    pub out: PathBuf,
    /// The folder of the runs. An interrupted study continues in this folder.
    pub runs: PathBuf,
    /// The Python interpreter that has MuJoCo, for a study in which robots walk in MuJoCo.
    pub python: PathBuf,
    /// The laws and losses that scenes may name.
    pub registry: Registry,
}

impl Study {
    /// The command line that repeats the study.
    pub(super) fn command(&self) -> String {
        let (study, seeds) = (in_shell(self.file.path.as_ref()), self.seeds);
        let limit = self.iterations.map(|n| format!(" --iterations {n}"));
        let base = (!self.base.file.is_empty())
            .then(|| format!(" --base {}", in_shell(self.base.file.as_ref())));
        let more = limit.into_iter().chain(base).collect::<String>();
        format!(
            "cosmic study {study} --first-seed {} --seeds {seeds}{more}",
            self.first_seed
        )
    }

    /// Writes the plan into the folder of the runs and freezes it, so that any process may carry it out. Replaces an
    /// existing plan, whose trials and seeds may differ.
    ///
    /// # Errors
    /// The errors of the file's scenes and of [`SweepPlan::freeze`]; [`Error::Usage`] if a trial of the existing plan
    /// has another scene or another number of iterations; [`Error::Usage`] if robots walk in MuJoCo but Python does not
    /// have it.
    pub fn prepare(&self) -> Result<SweepPlan> {
        let plan = self.plan(&self.file.trials(&self.base, &self.registry)?);
        plan.study.iter().try_for_each(PlannedStudy::check)?;
        if !self.runs.join(PLAN).exists() {
            return plan.freeze(&self.runs, &self.registry).map(|()| plan);
        }
        let before = SweepPlan::read(&self.runs)?;
        let is_other = |then: &PlannedScene| {
            let is_it = |now: &PlannedScene| now.name == then.name && now.scene != then.scene;
            plan.scenes.iter().any(is_it)
        };
        if before.iterations != plan.iterations || before.scenes.iter().any(is_other) {
            let runs = self.runs.display();
            return Err(Error::Usage(format!(
                "{runs}: the runs in this folder have other scenes or another number of iterations; name another \
                 folder with --runs"
            )));
        }
        if before != plan {
            plan.check(&self.registry)?;
            plan.write(&self.runs)?;
        }
        Ok(plan)
    }

    /// The plan of the study's sweep: every trial with every seed.
    fn plan(&self, trials: &[Trial]) -> SweepPlan {
        let frictions = self.file.keys.mujoco.clone();
        let python = (!frictions.is_empty()).then(|| self.python.display().to_string());
        let scene = |trial: &Trial| PlannedScene::new(trial.name.clone(), &trial.scene);
        SweepPlan {
            study: Some(PlannedStudy {
                kind: self.file.name.clone(),
                python,
                frictions,
            }),
            first_seed: self.first_seed,
            seeds: self.seeds,
            iterations: self.iterations,
            scenes: trials.iter().map(scene).collect(),
        }
    }

    /// Creates the folder of the results, does all unfinished runs in parallel, one on each thread, and measures the
    /// delivered designs.
    ///
    /// # Errors
    /// The errors of [`make_folder`] and [`Sweep::run_all`]; [`Error::Usage`] if other processes are doing some of
    /// the runs.
    pub fn simulate(
        &self,
        plan: &SweepPlan,
        threads: Option<NonZeroUsize>,
        overseer: &dyn Overseer,
    ) -> Result<()> {
        make_folder(&self.out)?;
        let (folder, registry) = (&*self.runs, &self.registry);
        let sweep = Sweep {
            folder,
            plan,
            registry,
        };
        sweep.run_all(threads, overseer)?;
        match plan.runs() - plan.over(folder) {
            0 => Ok(()),
            left => Err(Error::Usage(format!(
                "{left} runs are still being done by other processes; repeat the command when they are finished"
            ))),
        }
    }

    /// Writes the results from the runs' records and returns the paths.
    ///
    /// # Errors
    /// If a record is missing or malformed, or a file cannot be written.
    pub fn write(&self) -> Result<Vec<PathBuf>> {
        let trials = self.file.trials(&self.base, &self.registry)?;
        let (plan, seeds) = (self.plan(&trials), self.seeds.get());
        let has_goals = |scene: &Scene| scene.controller.goals == GoalKind::Given;
        let any_goals = trials.iter().any(|trial| has_goals(&trial.scene));
        let run = |index: usize, scene: &Scene| -> Result<Run> {
            let length = Lattice::new(&scene.lattice, &scene.physics).length();
            let (folder, seed) = (plan.folder(&self.runs, index), plan.parts(index).1);
            let state = RunState::of(&folder);
            // A finished run may lack its measurements, if its process was killed before it measured.
            let mut study = plan.study.iter().filter(|_| state == RunState::Done);
            study.try_for_each(|study| {
                study.measure(&folder, &self.registry, &|| false).map(drop)
            })?;
            let finished = (state != RunState::Diverged).then_some(&*folder);
            let errands = match finished {
                _ if !has_goals(scene) => None,
                Some(folder) => Some(Errands::read(folder)?),
                None => Some(Errands::of_diverged(scene.goals.count)),
            };
            let mut numbers = numbers(finished, length, &self.file.keys.mujoco)?;
            if any_goals {
                numbers.extend(Errands::numbers(errands.as_ref()));
            }
            Ok(Run {
                seed,
                folder,
                numbers,
                errands,
            })
        };
        let row = |(k, trial): (usize, Trial)| {
            let runs = (k * seeds..(k + 1) * seeds).map(|index| run(index, &trial.scene));
            Ok(TrialRow {
                runs: runs.collect::<Result<_>>()?,
                trial,
            })
        };
        let rows = trials.into_iter().enumerate().map(row);
        self.write_results(&rows.collect::<Result<Vec<_>>>()?)
    }
}
