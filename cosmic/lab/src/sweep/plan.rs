//! `plan.json`: the scenes and seeds of a sweep, fixed when it is planned.

use super::RunState;
use cosmic::codesign::CoDesign;
use cosmic::error::{Error, Result};
use cosmic::record::files::{Format, is_used, make_folder, read_json, write_json};
use cosmic::record::snapshot;
use cosmic::record::{MOST_RUNS, RunPlan};
use cosmic::scene::Scene;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf, is_separator};

/// The format of a plan.
pub(super) const FORMAT: Format = Format {
    name: "cosmic-sweep-plan",
    version: 1,
};

/// The plan's place in a sweep's folder.
pub const PLAN: &str = "plan.json";

/// The copy of the plan that the runs began with: it gives an edited `plan.json` away.
const FROZEN: &str = "claims/plan.json";

/// A scene of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlannedScene {
    /// Its name, unique within a sweep.
    pub name: String,
    /// The scene; in the file as TOML.
    #[serde(with = "snapshot::toml")]
    pub scene: Scene,
}

/// Every scene with every seed. Runs are numbered scene by scene, the seeds of each in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SweepPlan {
    /// The scenes.
    pub scenes: Vec<PlannedScene>,
    /// The first seed.
    pub first_seed: u64,
    /// The number of seeds, from the first on.
    pub seeds: NonZeroUsize,
    /// Stops every run after this many iterations, even if its scene has more.
    pub iterations: Option<NonZeroUsize>,
}

impl SweepPlan {
    /// Checks that every run can begin, and that runs do not share a folder.
    ///
    /// # Errors
    /// [`Error::Usage`] for no scenes, two scenes of one name, a name that is no folder's, more
    /// than a million runs, seeds beyond the largest, and a scene that cannot be optimised.
    pub fn check(&self) -> Result<()> {
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
        for PlannedScene { name, scene } in &self.scenes {
            if name.is_empty() || name.starts_with('.') || name.contains(is_separator) {
                return refuse(format!("`{name}` cannot name the folder of a run"));
            }
            if !names.insert(name) {
                return refuse(format!("two scenes are called `{name}`"));
            }
            CoDesign::new(scene)?.begin(self.first_seed)?;
        }
        Ok(())
    }

    /// Writes the plan into a new or empty folder.
    ///
    /// # Errors
    /// The errors of [`check`](Self::check); [`Error::Usage`] for a folder that holds something;
    /// [`Error::Write`].
    pub fn freeze(&self, folder: &Path) -> Result<()> {
        self.check()?;
        match is_used(folder) {
            Ok(true) => {
                let folder = folder.display();
                Err(Error::Usage(format!("{folder}: the folder is not empty")))
            }
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(Error::reading(folder)(source))
            }
            Ok(false) | Err(_) => self.write(folder),
        }
    }

    /// Replaces the plan of a folder. Runs of scenes and seeds that both plans have are kept.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, folder: &Path) -> Result<()> {
        make_folder(folder)?;
        let frozen = folder.join(FROZEN);
        match fs::remove_file(&frozen) {
            Err(source) if source.kind() != ErrorKind::NotFound => {
                Err(Error::writing(&frozen)(source))
            }
            _ => write_json(&folder.join(PLAN), FORMAT, self),
        }
    }

    /// Keeps a copy of the plan when the first run begins.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub(super) fn keep(&self, folder: &Path) -> Result<()> {
        let path = folder.join(FROZEN);
        if path.exists() {
            return Ok(());
        }
        make_folder(&folder.join("claims"))?;
        write_json(&path, FORMAT, self)
    }

    /// The plan of a folder.
    ///
    /// # Errors
    /// The errors of [`read_json`] and [`check`](Self::check); [`Error::Usage`] for a plan that was
    /// edited after runs began.
    pub fn read(folder: &Path) -> Result<Self> {
        let [path, frozen] = [PLAN, FROZEN].map(|name| folder.join(name));
        let plan: Self = read_json(&path, FORMAT)?;
        let refuse = |what: String| Err(Error::Usage(format!("{}: {what}", path.display())));
        match plan.check() {
            Err(Error::Usage(what)) => return refuse(what),
            checked => checked?,
        }
        if !frozen.exists() {
            return Ok(plan);
        }
        let before: Self = read_json(&frozen, FORMAT)?;
        let mut pairs = plan.settings().into_iter().zip(before.settings());
        match pairs.find(|(now, before)| now != before) {
            None => Ok(plan),
            Some(([key, now], [_, before])) => refuse(format!(
                "edited after its runs began: `{key}` is {now}, where it was {before}; put it back, \
                 or plan another sweep"
            )),
        }
    }

    /// Every setting: its name and its value.
    fn settings(&self) -> Vec<[String; 2]> {
        let names = self.scenes.iter().map(|planned| &planned.name[..]);
        let iterations = self.iterations.map_or("null".to_owned(), |n| n.to_string());
        let own = [
            ["scenes".to_owned(), names.collect::<Vec<_>>().join(", ")],
            ["first_seed".to_owned(), self.first_seed.to_string()],
            ["seeds".to_owned(), self.seeds.to_string()],
            ["iterations".to_owned(), iterations],
        ];
        let of_scenes = self.scenes.iter().flat_map(|PlannedScene { name, scene }| {
            let settings = scene.settings().into_iter();
            settings.map(move |s| [format!("{name}: {}", s.key), s.value])
        });
        own.into_iter().chain(of_scenes).collect()
    }

    /// The number of runs.
    pub fn runs(&self) -> usize {
        self.scenes.len() * self.seeds.get()
    }

    /// The number of runs that are over, judged by their files.
    pub fn over(&self, sweep: &Path) -> usize {
        let is_over = |index: &usize| RunState::of(&self.folder(sweep, *index)).is_over();
        (0..self.runs()).filter(is_over).count()
    }

    /// The scene and the seed of a run.
    pub fn parts(&self, index: usize) -> (&PlannedScene, u64) {
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

    /// The plan of one run.
    pub fn run(&self, index: usize) -> RunPlan {
        let (PlannedScene { name, scene }, seed) = self.parts(index);
        RunPlan {
            iterations: self.iterations,
            ..RunPlan::new(name, scene.clone(), seed)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{FORMAT, PLAN, PlannedScene, SweepPlan};
    use cosmic::record::files::write_json;
    use cosmic::scene::Scene;
    use std::num::NonZeroUsize;
    use std::path::Path;

    fn plan(names: &[&str], first_seed: u64) -> SweepPlan {
        let scene = |name: &&str| PlannedScene {
            name: (*name).to_owned(),
            scene: Scene::default(),
        };
        SweepPlan {
            scenes: names.iter().map(scene).collect(),
            first_seed,
            seeds: NonZeroUsize::new(3).unwrap(),
            iterations: None,
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
        assert_eq!((plan.run(4).seed, &plan.run(4).name[..]), (6, "b"));
    }

    #[test]
    fn a_plan_may_be_edited_before_runs_begin_and_by_a_study() {
        let folder = tempfile::tempdir().unwrap();
        let mut plan = plan(&["a"], 0);
        plan.freeze(folder.path()).unwrap();
        assert_eq!(SweepPlan::read(folder.path()).unwrap(), plan);
        plan.first_seed = 1;
        write_json(&folder.path().join(PLAN), FORMAT, &plan).unwrap();
        assert_eq!(SweepPlan::read(folder.path()).unwrap(), plan);
        plan.keep(folder.path()).unwrap();
        plan.scenes[0].scene.physics.gravity = 5.0;
        // A study may: it replaces its plan.
        plan.write(folder.path()).unwrap();
        assert_eq!(SweepPlan::read(folder.path()).unwrap(), plan);
    }

    #[test]
    fn plans_that_cannot_be_carried_out_are_refused() {
        let refusal = |plan: SweepPlan| plan.check().unwrap_err().to_string();
        assert!(refusal(plan(&[], 0)).contains("needs a scene"));
        assert!(refusal(plan(&["../a"], 0)).contains("`../a` cannot name"));
        assert!(refusal(plan(&["a"], u64::MAX)).contains("too many"));
    }
}
