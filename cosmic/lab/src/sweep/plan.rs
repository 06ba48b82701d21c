//! The scenes and seeds of a sweep, fixed when it is planned.

use super::RunState;
use crate::measure::{Check, Errands, Walks, check_python};
use cosmic::Registry;
use cosmic::codesign::CoDesign;
use cosmic::error::{Error, Result};
use cosmic::record::snapshot::SavedScene;
use cosmic::record::{MOST_RUNS, RunPlan};
use cosmic::scene::Scene;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf, is_separator};

/// The name of the plan's file in a sweep's folder.
pub const PLAN: &str = "plan.json";

/// A scene of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedScene {
    /// The scene's name, unique within a sweep.
    pub name: String,
    /// The values that the scene has for the keys that the sweep varies; empty without a grid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub swept: Vec<SweptValue>,
    /// The text of the scene, as the plan's file contains it. It is parsed only when it is needed, because a process
    /// may do only one of thousands of runs.
    pub scene: SavedScene,
}

/// A key that a sweep varies, and the value that a scene has for it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweptValue {
    /// The key, such as `physics.friction`.
    pub key: String,
    /// The value of the key.
    pub value: Value,
}

impl PlannedScene {
    /// Makes a scene for a sweep without a grid.
    pub fn new(name: String, scene: &Scene) -> Self {
        let mut scene = SavedScene::from(scene);
        // Comments are removed: they are nine tenths of the text, and a plan may have thousands of scenes.
        let lines = scene.text.lines();
        let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
        scene.text = lines.map(|line| format!("{line}\n")).collect();
        Self {
            name,
            swept: Vec::new(),
            scene,
        }
    }
}

/// The plan of a sweep: a run for every scene and every seed. The runs are numbered scene by scene, and within a scene
/// in the order of the seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPlan {
    /// The study that the runs belong to, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<PlannedStudy>,
    /// The first seed.
    pub first_seed: u64,
    /// The number of consecutive seeds.
    pub seeds: NonZeroUsize,
    /// If set, the phases of every scene are fitted into this many iterations.
    pub iterations: Option<NonZeroUsize>,
    /// The scenes.
    pub scenes: Vec<PlannedScene>,
}

/// The study to which a plan's runs belong. It says how finished runs are measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedStudy {
    /// The name of the study.
    pub kind: String,
    /// The Python interpreter that has MuJoCo, if robots walk in MuJoCo.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub python: Option<String>,
    /// The coefficients of friction with which robots walk in MuJoCo.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frictions: Vec<f64>,
}

impl PlannedStudy {
    /// Checks that this machine has what the measurements need.
    ///
    /// # Errors
    /// [`Error::Usage`] if robots walk in MuJoCo but the Python of this study does not have MuJoCo.
    pub fn check(&self) -> Result<()> {
        let mut python = self.python.iter();
        python.try_for_each(|python| check_python(python.as_ref()))
    }

    /// Measures a finished run and writes the files of its measurements. Files that exist are kept. Returns `None` if
    /// the measurement was stopped.
    ///
    /// # Errors
    /// The errors of reading and writing the run's files; [`Error::Usage`] if Python fails.
    pub(crate) fn measure(
        &self,
        run: &Path,
        registry: &Registry,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Option<()>> {
        Check::keep(run, registry)?;
        if Errands::keep(run, registry, is_stopped)?.is_none() {
            return Ok(None);
        }
        match &self.python {
            None => Ok(Some(())),
            Some(python) => {
                let python = python.as_ref();
                Walks::keep(run, &self.frictions, python, registry, is_stopped)
            }
        }
    }
}

impl SweepPlan {
    /// Checks that every run can begin, and that no two runs have the same folder.
    ///
    /// # Errors
    /// [`Error::Usage`] for a plan without scenes, two scenes with the same name, a name that a folder cannot have, more
    /// than a million runs, or seeds above the largest allowed one; the errors of scenes that cannot be optimised.
    pub fn check(&self, registry: &Registry) -> Result<()> {
        self.check_shape()?;
        let begins = |index: usize| {
            let scene = self.scene(index, registry)?;
            CoDesign::new(&scene)?.begin(self.first_seed).map(drop)
        };
        let indices = 0..self.scenes.len();
        indices.into_par_iter().try_for_each(begins)
    }

    /// Parses the scene with this index, and fits its phases into the planned number of iterations.
    ///
    /// # Errors
    /// [`Error::Usage`] for a malformed scene, and for too many iterations.
    fn scene(&self, index: usize, registry: &Registry) -> Result<Scene> {
        let scene = &self.scenes[index].scene;
        let read = scene.read(&format!("scenes[{index}].scene"), registry);
        let scene = read.map_err(|error| Error::Usage(format!("{PLAN}: {}", error.within())))?;
        (self.iterations).map_or(Ok(scene.clone()), |iterations| scene.fitted(iterations))
    }

    /// Returns the plan of the run with this number. Its scene may name the laws and losses of `registry`.
    ///
    /// # Errors
    /// [`Error::Usage`] for a malformed scene.
    pub fn run(&self, index: usize, registry: &Registry) -> Result<RunPlan> {
        let (planned, seed) = self.parts(index);
        let scene = self.scene(index / self.seeds.get(), registry)?;
        Ok(RunPlan::new(&planned.name, scene, seed))
    }

    /// Checks the number of runs and the names of their folders.
    ///
    /// # Errors
    /// [`Error::Usage`] for a plan without scenes, two scenes with the same name, a name that a folder cannot have,
    /// more than a million runs, or seeds above the largest allowed one.
    pub(super) fn check_shape(&self) -> Result<()> {
        let refuse = |what: String| Err(Error::Usage(what));
        if self.scenes.is_empty() {
            return refuse("the sweep has no scene; it needs at least one".to_owned());
        }
        let (scenes, seeds) = (self.scenes.len(), self.seeds.get());
        let runs = scenes.saturating_mul(seeds);
        if runs > MOST_RUNS {
            return refuse(format!(
                "{runs} runs (scenes x seeds: {scenes} x {seeds}) are too many; at most {MOST_RUNS} are \
                 allowed"
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
        for PlannedScene { name, .. } in &self.scenes {
            if name.is_empty() || name.starts_with('.') || name.contains(is_separator) {
                return refuse(format!(
                    "the scene name `{name}` cannot be the name of a folder; rename the scene"
                ));
            }
            if !names.insert(name) {
                return refuse(format!(
                    "two scenes have the name `{name}`; rename one of them"
                ));
            }
        }
        Ok(())
    }

    /// The number of runs.
    pub fn runs(&self) -> usize {
        self.scenes.len() * self.seeds.get()
    }

    /// The keys that the sweep varies, without repetition, in the order of the grid.
    pub fn swept_keys(&self) -> Vec<&str> {
        let mut keys = Vec::new();
        for swept in self.scenes.iter().flat_map(|planned| &planned.swept) {
            if !keys.contains(&&swept.key[..]) {
                keys.push(&swept.key[..]);
            }
        }
        keys
    }

    /// Counts the finished runs. `sweep` is the folder of the sweep.
    pub fn over(&self, sweep: &Path) -> usize {
        let is_over = |index: &usize| RunState::of(&self.folder(sweep, *index)).is_over();
        (0..self.runs()).filter(is_over).count()
    }

    /// Returns the scene and the seed of the run with this number.
    pub fn parts(&self, index: usize) -> (&PlannedScene, u64) {
        let (scene, seed) = (index / self.seeds.get(), index % self.seeds.get());
        (&self.scenes[scene], self.first_seed + seed as u64)
    }

    /// The name of a run's folder and of its claim.
    pub fn name(&self, index: usize) -> String {
        let (scene, seed) = self.parts(index);
        format!("{}-{seed}", scene.name)
    }

    /// The folder of a run, inside the folder `sweep`.
    pub fn folder(&self, sweep: &Path, index: usize) -> PathBuf {
        sweep.join("runs").join(self.name(index))
    }
}
