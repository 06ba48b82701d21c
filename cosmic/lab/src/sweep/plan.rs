//! The trials and seeds of a sweep.

use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::format::Format;
use cosmic::record::files::{is_used, make_folder, read_json, write_json};
use cosmic::record::snapshot::SavedScene;
use cosmic::record::summary::SUMMARY;
use cosmic::record::{DIVERGED, MOST_RUNS, RunPlan};
use cosmic::scene::Scene;
use cosmic::search::CoDesign;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeSet;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf, is_separator};

/// The name of the plan's file in a sweep's folder.
pub const SWEEP: &str = "sweep.json";

const FORMAT: Format = Format::new("cosmic-sweep", 1);

/// A scene of a sweep, which is run with every seed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// The name, unique within a sweep.
    pub name: String,
    /// The name in tables for people.
    pub title: String,
    /// A published displacement to compare the median with, m.
    pub published: Option<f64>,
    /// The keys that the grid varies, with the values in this trial; empty without a grid.
    pub swept: Map<String, Value>,
    /// The text of the scene. It is parsed only when it is needed, because a process may do only one of thousands of
    /// runs.
    pub scene: SavedScene,
}

/// The plan of a sweep: a run for every trial and every seed. The runs are numbered trial by trial, and within a trial in
/// the order of the seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// The first seed.
    pub first_seed: u64,
    /// The number of consecutive seeds.
    pub seeds: NonZeroUsize,
    /// The trials.
    pub trials: Vec<Trial>,
}

impl Plan {
    /// Writes the plan into the folder of the sweep, which is new, empty, or has a plan already. In the last case, this
    /// plan may have more trials and other seeds.
    ///
    /// # Errors
    /// [`Error::Usage`] if the folder has other files but no plan, and if it has a trial that this plan lacks or for
    /// which it has another scene; the errors of scenes that cannot be optimised; [`Error::Write`].
    pub fn keep(&self, folder: &Path, registry: &Registry) -> Result<()> {
        // Another process may write its plan between the two checks, so the plan is looked for last.
        let is_used = is_used(folder).unwrap_or(false);
        if is_used && !folder.join(SWEEP).exists() {
            return Err(Error::Usage(format!(
                "{}: the folder is not empty, but it does not contain a sweep; name another folder with --out",
                folder.display()
            )));
        }
        if is_used {
            let before = Self::read(folder)?;
            if before == *self {
                return Ok(());
            }
            let is_kept = |then: &&Trial| {
                let is_it = |now: &Trial| now.name == then.name && now.scene == then.scene;
                self.trials.iter().any(is_it)
            };
            if let Some(other) = before.trials.iter().find(|then| !is_kept(then)) {
                return Err(Error::Usage(format!(
                    "{}: this folder holds another sweep: its trial `{}` is missing here or has another scene; name \
                     another folder with --out",
                    folder.display(),
                    other.name
                )));
            }
        }
        let begins = |index: usize| {
            let scene = self.run(index * self.seeds.get(), registry)?.scene;
            CoDesign::new(&scene)?.begin(self.first_seed).map(drop)
        };
        let trials = self.trials.par_iter().enumerate();
        trials.try_for_each(|(index, trial)| {
            begins(index).map_err(|error| Error::PassedOver {
                run: format!("trial {}", trial.name),
                error: Box::new(error),
                others: 0,
            })
        })?;
        make_folder(folder)?;
        write_json(&folder.join(SWEEP), FORMAT, self)
    }

    /// Reads the plan in the folder of a sweep.
    ///
    /// # Errors
    /// [`Error::Read`] for a folder without a plan; the errors of [`read_json`]; [`Error::Usage`] for a plan with too
    /// many runs or two trials of the same name.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(SWEEP);
        if folder.exists() && !path.exists() {
            let says = format!("it is not the folder of a sweep, because it has no {SWEEP}");
            return Err(Error::reading(folder)(io::Error::other(says)));
        }
        let plan: Self = read_json(&path, FORMAT).map_err(|mut error| {
            if let Error::Malformed { report, .. } = &mut error {
                *report += "\n  = the file is damaged: restore it from a copy, or begin the sweep again in another folder; to \
                            keep its runs, move the folder `runs` there before you repeat the command";
            }
            error
        })?;
        plan.check_shape().map(|()| plan)
    }

    /// Returns the plan of the run with this number. Its scene may name the laws and losses of `registry`.
    ///
    /// # Errors
    /// [`Error::Usage`] for a malformed scene, and if the sweep has no run of this number.
    pub fn run(&self, index: usize, registry: &Registry) -> Result<RunPlan> {
        if index >= self.runs() {
            return Err(Error::Usage(format!(
                "there is no run {index}; the runs of this sweep have the numbers 0 to {}",
                self.runs() - 1
            )));
        }
        let (trial, seed) = self.parts(index);
        let place = format!("{SWEEP}: trial {}", trial.name);
        let scene: Scene = trial.scene.read(&place, registry)?;
        Ok(RunPlan::new(&trial.name, scene, seed))
    }

    /// Checks the number of runs and the names of their folders.
    ///
    /// # Errors
    /// [`Error::Usage`] for a sweep without trials, two trials with the same name, a name that a folder cannot have,
    /// more than a million runs, or seeds above the largest allowed one.
    pub(super) fn check_shape(&self) -> Result<()> {
        let refuse = |what: String| Err(Error::Usage(what));
        if self.trials.is_empty() {
            return refuse("the sweep has no trial; it needs at least one".to_owned());
        }
        let (trials, seeds) = (self.trials.len(), self.seeds.get());
        let runs = trials.saturating_mul(seeds);
        if runs > MOST_RUNS {
            return refuse(format!(
                "{runs} runs (trials x seeds: {trials} x {seeds}) are too many; at most {MOST_RUNS} are allowed"
            ));
        }
        if self.first_seed.checked_add(seeds as u64 - 1).is_none() {
            let first = self.first_seed;
            return refuse(format!(
                "{seeds} seeds from {first} on are too many: the last would exceed {}; choose a lower first seed",
                u64::MAX
            ));
        }
        let mut names = BTreeSet::new();
        for Trial { name, .. } in &self.trials {
            if name.is_empty() || name.starts_with('.') || name.contains(is_separator) {
                return refuse(format!(
                    "the trial name `{name}` cannot be the name of a folder; rename the trial or its scene"
                ));
            }
            if !names.insert(name) {
                return refuse(format!(
                    "two trials have the name `{name}`; rename one of them"
                ));
            }
        }
        Ok(())
    }

    /// The number of runs.
    pub fn runs(&self) -> usize {
        self.trials.len() * self.seeds.get()
    }

    /// The keys that the grid varies, in the order of the columns.
    pub(super) fn swept_keys(&self) -> Vec<&str> {
        let first = self.trials.first().into_iter();
        first
            .flat_map(|trial| trial.swept.keys())
            .map(|key| &key[..])
            .collect()
    }

    /// Returns the trial and the seed of the run with this number.
    pub fn parts(&self, index: usize) -> (&Trial, u64) {
        let (trial, seed) = (index / self.seeds.get(), index % self.seeds.get());
        (&self.trials[trial], self.first_seed + seed as u64)
    }

    /// The name of a run's folder.
    pub(super) fn name(&self, index: usize) -> String {
        let (trial, seed) = self.parts(index);
        format!("{}-{seed}", trial.name)
    }

    /// The folder of a run, inside the folder `sweep`.
    pub fn folder(&self, sweep: &Path, index: usize) -> PathBuf {
        sweep.join("runs").join(self.name(index))
    }

    /// True if the run with this number is finished, even if its robot diverged.
    pub fn is_over(&self, sweep: &Path, index: usize) -> bool {
        let folder = self.folder(sweep, index);
        folder.join(SUMMARY).exists() || folder.join(DIVERGED).exists()
    }

    /// The numbers of the unfinished runs.
    pub fn left(&self, sweep: &Path) -> impl Iterator<Item = usize> {
        (0..self.runs()).filter(|index| !self.is_over(sweep, *index))
    }
}
