//! The scenes and seeds of a sweep, fixed when it is planned.

use super::RunState;
use crate::measure::{Check, Walks, check_python};
use cosmic::codesign::CoDesign;
use cosmic::error::{Error, Result};
use cosmic::record::snapshot;
use cosmic::record::{MOST_RUNS, RunPlan};
use cosmic::scene::Scene;
use rayon::prelude::*;
use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;
use serde_json::value::RawValue;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf, is_separator};

/// The plan's place in a sweep's folder.
pub const PLAN: &str = "plan.json";

/// A scene of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(deserialize = "S: Planned", serialize = "S: Planned"))]
pub struct PlannedScene<S = Scene> {
    /// Its name, unique within a sweep.
    pub name: String,
    /// The scene's values of the keys that the sweep varies; empty without a grid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub swept: Vec<SweptValue>,
    /// The scene; in the file as TOML.
    #[serde(deserialize_with = "S::read", serialize_with = "S::write")]
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

/// What a plan holds of a scene: the scene, or nothing where names are enough.
pub trait Planned: Sized {
    /// Reads it from the scene's place in the file.
    ///
    /// # Errors
    /// What is wrong there.
    fn read<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error>;

    /// Writes it.
    ///
    /// # Errors
    /// The errors of the serializer.
    fn write<T: Serializer>(scene: &Self, to: T) -> std::result::Result<T::Ok, T::Error>;
}

impl Planned for Scene {
    fn read<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        snapshot::toml::deserialize(from)
    }

    fn write<T: Serializer>(scene: &Self, to: T) -> std::result::Result<T::Ok, T::Error> {
        let whole = snapshot::toml::serialize(scene, serde_json::value::Serializer);
        let mut whole = whole.map_err(serde::ser::Error::custom)?;
        let scene = match &mut whole {
            Value::Object(parts) => parts.get_mut("scene"),
            text => Some(text),
        };
        if let Some(text) = scene {
            without_comments(text);
        }
        whole.serialize(to)
    }
}

/// A scene as it stands in the plan's file, and is read from there only where it is needed: a process may do
/// one run of thousands.
#[derive(Clone, Debug)]
pub struct UnreadScene(Box<RawValue>);

impl Planned for UnreadScene {
    fn read<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        Box::deserialize(from).map(Self)
    }

    fn write<T: Serializer>(scene: &Self, to: T) -> std::result::Result<T::Ok, T::Error> {
        scene.0.serialize(to)
    }
}

/// A planned scene that can be had whole.
pub trait HasScene: Planned + Sync {
    /// The scene.
    ///
    /// # Errors
    /// [`Error::Usage`] for a scene that is malformed.
    fn scene(&self) -> Result<Scene>;
}

impl HasScene for Scene {
    fn scene(&self) -> Result<Scene> {
        Ok(self.clone())
    }
}

impl HasScene for UnreadScene {
    fn scene(&self) -> Result<Scene> {
        let mut from = serde_json::Deserializer::from_str(self.0.get());
        let refused = |error: serde_json::Error| Error::Usage(format!("{PLAN}: {error}"));
        snapshot::toml::deserialize(&mut from).map_err(refused)
    }
}

/// Leaves the comments of a scene's TOML out, nine tenths of it: a plan may have thousands of scenes.
fn without_comments(text: &mut Value) {
    if let Value::String(text) = text {
        let lines = text.lines();
        let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
        *text = lines.map(|line| format!("{line}\n")).collect();
    }
}

impl Planned for () {
    fn read<'de, D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        IgnoredAny::deserialize(from).map(drop)
    }

    fn write<T: Serializer>((): &Self, to: T) -> std::result::Result<T::Ok, T::Error> {
        to.serialize_unit()
    }
}

/// Every scene with every seed. Runs are numbered scene by scene, the seeds of each in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(deserialize = "S: Planned", serialize = "S: Planned"))]
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

/// A plan whose scenes are read run by run.
pub type UnreadPlan = SweepPlan<UnreadScene>;

/// A plan without its scenes' content: enough to say how far its runs are.
pub type PlanOutline = SweepPlan<()>;

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
    pub(crate) fn measure(&self, run: &Path, is_stopped: &dyn Fn() -> bool) -> Result<Option<()>> {
        Check::keep(run)?;
        match &self.python {
            None => Ok(Some(())),
            Some(python) => Walks::keep(run, &self.frictions, python.as_ref(), is_stopped),
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

impl<S: HasScene> SweepPlan<S> {
    /// The plan of one run.
    ///
    /// # Errors
    /// The errors of [`HasScene::scene`].
    pub fn run(&self, index: usize) -> Result<RunPlan> {
        let (PlannedScene { name, scene, .. }, seed) = self.parts(index);
        Ok(RunPlan {
            iterations: self.iterations,
            ..RunPlan::new(name, scene.scene()?, seed)
        })
    }
}

impl<S> SweepPlan<S> {
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
        let fifth = plan.run(4).unwrap();
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
