//! The scenes and seeds of a sweep, fixed when it is planned.

use super::RunState;
use crate::measure::{Check, Walks, check_python};
use cosmic::Registry;
use cosmic::codesign::CoDesign;
use cosmic::error::{Error, Result};
use cosmic::record::snapshot::SavedScene;
use cosmic::record::{MOST_RUNS, RunPlan};
use cosmic::scene::Scene;
use rayon::prelude::*;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf, is_separator};

/// The plan's place in a sweep's folder.
pub const PLAN: &str = "plan.json";

/// A scene of a sweep; in a file it is a [`SavedScene`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedScene<S = Scene> {
    /// Its name, unique within a sweep.
    pub name: String,
    /// The scene's values of the keys that the sweep varies; empty without a grid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub swept: Vec<SweptValue>,
    /// The scene.
    pub scene: S,
}

/// A key that a sweep varies, and its value in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweptValue {
    /// The key, such as `physics.friction`.
    pub key: String,
    /// The value.
    pub value: Value,
}

/// The scene of a plan in a form from which it can be made.
pub trait HasScene: Sync {
    /// The scene. `place` names it in messages.
    ///
    /// # Errors
    /// [`Error::Usage`] for a malformed scene.
    fn scene(&self, place: &str, registry: &Registry) -> Result<Scene>;
}

impl HasScene for Scene {
    fn scene(&self, _: &str, _: &Registry) -> Result<Scene> {
        Ok(self.clone())
    }
}

impl HasScene for SavedScene {
    fn scene(&self, place: &str, registry: &Registry) -> Result<Scene> {
        let refused = |error: Error| Error::Usage(format!("{PLAN}: {error}"));
        self.read(place, registry).map_err(refused)
    }
}

/// Leaves the comments of a scene's TOML out, nine tenths of it: a plan may have thousands of scenes.
fn without_comments(text: &str) -> String {
    let lines = text.lines();
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    lines.map(|line| format!("{line}\n")).collect()
}

/// Every scene with every seed. Runs are numbered scene by scene, the seeds of each in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPlan<S = Scene> {
    /// The study that the runs are of, if they are of one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub study: Option<PlannedStudy>,
    /// The first seed.
    pub first_seed: u64,
    /// The number of seeds, from the first on.
    pub seeds: NonZeroUsize,
    /// Stops every run after this many iterations, even if its scene has more.
    pub iterations: Option<NonZeroUsize>,
    /// The scenes.
    pub scenes: Vec<PlannedScene<S>>,
}

/// A plan as its file has it. A scene is read when one of its runs begins: a process may do one run of thousands.
pub type UnreadPlan = SweepPlan<SavedScene>;

/// A plan without its scenes' content: enough to say how far its runs are.
pub type PlanOutline = SweepPlan<IgnoredAny>;

/// The study that a plan's runs are of: they are measured as its runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedStudy {
    /// The study's name.
    pub kind: String,
    /// The Python with MuJoCo, if robots walk there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub python: Option<String>,
    /// The coefficients of friction on which robots walk in MuJoCo.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frictions: Vec<f64>,
}

impl PlannedStudy {
    /// Checks that this machine can measure.
    ///
    /// # Errors
    /// [`Error::Usage`] if robots walk in MuJoCo and the Python lacks it.
    pub fn check(&self) -> Result<()> {
        let mut python = self.python.iter();
        python.try_for_each(|python| check_python(python.as_ref()))
    }

    /// Measures a run that is done and writes the files of the measurements, except those that exist. Returns
    /// `None` if it was stopped.
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
    /// Checks that every run can begin, and that runs do not share a folder.
    ///
    /// # Errors
    /// [`Error::Usage`] for no scenes, two of one name, a name that is no folder's, too many runs or seeds, and
    /// the errors of a scene that cannot be optimised.
    pub fn check(&self) -> Result<()> {
        self.check_shape()?;
        let begins = |planned: &PlannedScene| {
            let begun = CoDesign::new(&planned.scene)?.begin(self.first_seed);
            begun.map(drop)
        };
        self.scenes.par_iter().try_for_each(begins)
    }
}

impl SweepPlan {
    /// The plan as its file has it.
    pub(super) fn saved(&self) -> UnreadPlan {
        let saved = |_, scene: &Scene| {
            let mut saved = SavedScene::from(scene);
            saved.text = without_comments(&saved.text);
            Ok(saved)
        };
        self.with_scenes(saved).expect("every scene can be saved")
    }
}

impl UnreadPlan {
    /// Reads all scenes.
    ///
    /// # Errors
    /// The errors of [`HasScene::scene`].
    pub fn whole(&self, registry: &Registry) -> Result<SweepPlan> {
        self.with_scenes(|k, scene| scene.scene(&place(k), registry))
    }
}

/// The place of a scene in the file of a plan.
fn place(scene: usize) -> String {
    format!("scenes[{scene}].scene")
}

impl<S: HasScene> SweepPlan<S> {
    /// The plan of one run, whose scene may name the items of a registry.
    ///
    /// # Errors
    /// The errors of [`HasScene::scene`].
    pub fn run(&self, index: usize, registry: &Registry) -> Result<RunPlan> {
        let (PlannedScene { name, scene, .. }, seed) = self.parts(index);
        let scene = scene.scene(&place(index / self.seeds.get()), registry)?;
        Ok(RunPlan {
            iterations: self.iterations,
            ..RunPlan::new(name, scene, seed)
        })
    }
}

impl<S> SweepPlan<S> {
    /// The plan with each scene, given by its number, in another form.
    fn with_scenes<T>(&self, form: impl Fn(usize, &S) -> Result<T>) -> Result<SweepPlan<T>> {
        let scenes = self.scenes.iter().enumerate();
        let scenes = scenes.map(|(k, planned)| {
            Ok(PlannedScene {
                name: planned.name.clone(),
                swept: planned.swept.clone(),
                scene: form(k, &planned.scene)?,
            })
        });
        Ok(SweepPlan {
            study: self.study.clone(),
            first_seed: self.first_seed,
            seeds: self.seeds,
            iterations: self.iterations,
            scenes: scenes.collect::<Result<_>>()?,
        })
    }

    /// Checks the number of runs and the names of their folders.
    ///
    /// # Errors
    /// [`Error::Usage`] for no scenes, two scenes of one name, a name that is no folder's, more
    /// than a million runs, and seeds beyond the largest.
    pub(super) fn check_shape(&self) -> Result<()> {
        let refuse = |what: String| Err(Error::Usage(what));
        if self.scenes.is_empty() {
            return refuse("a sweep needs a scene".to_owned());
        }
        let (scenes, seeds) = (self.scenes.len(), self.seeds.get());
        let runs = scenes.saturating_mul(seeds);
        if runs > MOST_RUNS {
            return refuse(format!(
                "{runs} runs (scenes x seeds: {scenes} x {seeds}), where at most {MOST_RUNS} are \
                 allowed"
            ));
        }
        if self.first_seed.checked_add(seeds as u64 - 1).is_none() {
            let first = self.first_seed;
            return refuse(format!("{seeds} seeds from {first} on are too many"));
        }
        let mut names = BTreeSet::new();
        for PlannedScene { name, .. } in &self.scenes {
            if name.is_empty() || name.starts_with('.') || name.contains(is_separator) {
                return refuse(format!("`{name}` cannot name the folder of a run"));
            }
            if !names.insert(name) {
                return refuse(format!("two scenes are called `{name}`"));
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

    /// The number of runs that are over, judged by their files.
    pub fn over(&self, sweep: &Path) -> usize {
        let is_over = |index: &usize| RunState::of(&self.folder(sweep, *index)).is_over();
        (0..self.runs()).filter(is_over).count()
    }

    /// The scene and the seed of a run.
    pub fn parts(&self, index: usize) -> (&PlannedScene<S>, u64) {
        let (scene, seed) = (index / self.seeds.get(), index % self.seeds.get());
        (&self.scenes[scene], self.first_seed + seed as u64)
    }

    /// The name of a run's folder and of its claim.
    pub fn name(&self, index: usize) -> String {
        let (scene, seed) = self.parts(index);
        format!("{}-{seed}", scene.name)
    }

    /// A run's folder in the sweep's.
    pub fn folder(&self, sweep: &Path, index: usize) -> PathBuf {
        sweep.join("runs").join(self.name(index))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{PlannedScene, SweepPlan};
    use cosmic::Registry;
    use cosmic::scene::Scene;
    use std::num::NonZeroUsize;
    use std::path::Path;

    pub(in crate::sweep) fn plan(names: &[&str], first_seed: u64) -> SweepPlan {
        let scene = |name: &&str| PlannedScene {
            name: (*name).to_owned(),
            swept: Vec::new(),
            scene: Scene::paper(),
        };
        SweepPlan {
            study: None,
            first_seed,
            seeds: NonZeroUsize::new(3).unwrap(),
            iterations: None,
            scenes: names.iter().map(scene).collect(),
        }
    }

    #[test]
    fn runs_are_numbered_scene_by_scene() {
        let plan = plan(&["a", "b"], 5);
        let folders: Vec<_> = (0..plan.runs())
            .map(|k| plan.folder(Path::new("s"), k))
            .collect();
        let expected = ["a-5", "a-6", "a-7", "b-5", "b-6", "b-7"];
        assert_eq!(folders, expected.map(|name| Path::new("s/runs").join(name)));
        let fifth = plan.run(4, &Registry::default()).unwrap();
        assert_eq!((fifth.seed, &fifth.name[..]), (6, "b"));
    }

    #[test]
    fn plans_that_cannot_be_carried_out_are_refused() {
        let refusal = |plan: SweepPlan| plan.check().unwrap_err().to_string();
        assert!(refusal(plan(&[], 0)).contains("needs a scene"));
        assert!(refusal(plan(&["../a"], 0)).contains("`../a` cannot name"));
        assert!(refusal(plan(&["a"], u64::MAX)).contains("too many"));
    }
}
