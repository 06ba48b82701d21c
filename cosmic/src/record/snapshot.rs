//! `snapshot.json`: the plan and the state of a run, all that resuming needs.

use super::files::{no_run, read_json, write_json};
use super::format::{Format, parse_json};
use crate::codesign::{CoDesign, Progress};
use crate::error::{Error, Result};
use crate::scene::Scene;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::num::NonZeroUsize;
use std::path::Path;

/// The format of a snapshot.
pub const FORMAT: Format = Format::new("cosmic-snapshot", 1);

/// The name of the snapshot in the folder of a run.
pub const SNAPSHOT: &str = "snapshot.json";

/// The task of a run, or of several starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunPlan {
    /// The name of the scene.
    pub name: String,
    /// The scene; in the file as TOML.
    #[serde(with = "toml")]
    pub scene: Scene,
    /// The seed, or the first of several.
    pub seed: u64,
    /// How many seeds are tried.
    pub starts: NonZeroUsize,
    /// The run stops after so many iterations, if the scene has more.
    pub iterations: Option<NonZeroUsize>,
    /// Whether all starts are carried out.
    #[serde(default, skip_serializing_if = "Search::is_full")]
    pub search: Search,
}

/// How several starts are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Search {
    /// All starts are carried out.
    #[default]
    Full,
    /// Successive halving: weak starts are dropped early, by the scene's `[search]`.
    Halving,
}

impl Search {
    fn is_full(&self) -> bool {
        *self == Self::Full
    }
}

impl RunPlan {
    /// A whole run of one start.
    pub fn new(name: &str, scene: Scene, seed: u64) -> Self {
        Self {
            name: name.to_owned(),
            scene,
            seed,
            starts: NonZeroUsize::MIN,
            iterations: None,
            search: Search::Full,
        }
    }

    /// Checks that the run in a folder has this plan. `physics.unstable_step` may differ, because
    /// [`allow_unstable`](super::allow_unstable) changes it for a run that has begun.
    ///
    /// # Errors
    /// [`Error::Usage`] for a run of another scene, seed or number of iterations.
    pub(super) fn check_same(&self, expected: &Self, folder: &Path) -> Result<()> {
        let mut own = self.clone();
        own.scene.physics.unstable_step = expected.scene.physics.unstable_step;
        if own == *expected {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "{}: the folder holds another run (scene `{}`, seed {}) than the one that belongs there \
             (scene `{}`, seed {}, with other settings or another number of iterations); move it \
             elsewhere",
            folder.display(),
            self.name,
            self.seed,
            expected.name,
            expected.seed
        )))
    }

    /// The last iteration of a run from the scene's start.
    pub fn last_iteration(&self) -> usize {
        self.last_after(0)
    }

    /// The last iteration of a run that enters after iteration `entered`.
    pub(super) fn last_after(&self, entered: usize) -> usize {
        let all = self.scene.schedule.iterations;
        let last = |limit: NonZeroUsize| entered.saturating_add(limit.get()).min(all);
        self.iterations.map_or(all, last)
    }
}

/// A scene in JSON: its text, with the nodes and edges of a lattice of its own, so that no other file
/// is needed.
pub mod toml {
    use super::Scene;
    use crate::error;
    use crate::lattice::Truss;
    use crate::scene::TrussFile;
    use serde::de::value::MapAccessDeserializer;
    use serde::de::{Error, MapAccess, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::fmt;
    use std::sync::Arc;

    /// A scene whose lattice is a truss.
    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct OfTruss {
        scene: String,
        truss: Truss,
    }

    /// Writes the scene's TOML as a string, or as an object beside the truss of its lattice.
    ///
    /// # Errors
    /// The errors of the serializer.
    pub fn serialize<S: Serializer>(scene: &Scene, to: S) -> Result<S::Ok, S::Error> {
        let text = scene.to_run_toml();
        match scene.lattice.file.truss() {
            None => to.serialize_str(&text),
            Some(truss) => OfTruss {
                scene: text,
                truss: Truss::clone(truss),
            }
            .serialize(to),
        }
    }

    /// Reads the scene from what [`serialize`] writes.
    ///
    /// # Errors
    /// What is wrong with the TOML, with its line and column.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Scene, D::Error> {
        // By its own visitor: an error is then at the place of the scene in the file.
        from.deserialize_any(AnyForm)
    }

    struct AnyForm;

    impl<'de> Visitor<'de> for AnyForm {
        type Value = Scene;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("the text of a scene, or an object with the keys `scene` and `truss`")
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Scene, E> {
            Scene::parse_of_snapshot(text, None).map_err(told)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Scene, A::Error> {
            let parts = OfTruss::deserialize(MapAccessDeserializer::new(map))?;
            let truss = TrussFile::new(TrussFile::COPY, Arc::new(parts.truss));
            Scene::parse_of_snapshot(&parts.scene, Some(truss)).map_err(told)
        }
    }

    /// An error in a part of a sentence; its own report is a page.
    fn told<E: Error>(error: error::Error) -> E {
        match error {
            error::Error::Malformed {
                line,
                column,
                message,
                ..
            } => E::custom(format!(
                "the scene, line {line}, column {column}: {message}"
            )),
            error => E::custom(error),
        }
    }
}

/// A run's plan and state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Snapshot<'a> {
    pub(super) plan: Cow<'a, RunPlan>,
    /// Wall time so far, interruptions left out, s.
    pub(super) seconds: f64,
    /// `None` for several starts: each of them has its own snapshot.
    pub(super) progress: Option<Cow<'a, Progress>>,
}

impl Snapshot<'_> {
    /// Replaces a folder's snapshot by a plan and a state after so many seconds.
    pub(super) fn save(
        folder: &Path,
        plan: &RunPlan,
        seconds: f64,
        progress: Option<&Progress>,
    ) -> Result<()> {
        let snapshot = Snapshot {
            plan: Cow::Borrowed(plan),
            seconds,
            progress: progress.map(Cow::Borrowed),
        };
        snapshot.write(folder)
    }

    /// Replaces a folder's snapshot.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        write_json(&folder.join(SNAPSHOT), FORMAT, self)
    }

    /// The plan and the state, checked against an optimisation of the plan's scene. Messages name
    /// `file`.
    ///
    /// # Errors
    /// [`Error::Usage`] if the optimisation has another scene or another loss; those of
    /// [`CoDesign::first`] and [`Progress::fits`].
    pub(super) fn unpack(self, file: &Path, codesign: &CoDesign) -> Result<(RunPlan, Progress)> {
        let plan = self.plan.into_owned();
        if *codesign.scene() != plan.scene {
            return Err(Error::Usage(format!(
                "{}: the optimisation is not of the run's scene",
                file.display()
            )));
        }
        let first = codesign.first(plan.seed)?;
        let progress = self.progress.map_or(first.clone(), Cow::into_owned);
        if progress.own_loss != first.own_loss {
            let file = file.display();
            return Err(if progress.own_loss {
                Error::OwnLoss {
                    file: file.to_string(),
                    remedy: "goes on with it, by record::resume_with",
                }
            } else {
                Error::Usage(format!(
                    "{file}: the run is for its scene's objective, and no other loss"
                ))
            });
        }
        let file = &file.display().to_string();
        progress.fits(&first, file)?;
        let (snap_at, iteration) = (plan.scene.schedule.snap_at, progress.iteration);
        if let Some(entered) = progress.entered
            && ((entered != 0 && entered != snap_at) || entered > iteration)
        {
            return Err(Error::Usage(format!(
                "{file}: `progress.entered`: expected 0 or the iteration of the snap ({snap_at}) and at \
                 most {iteration}, found {entered}"
            )));
        }
        Ok((plan, progress))
    }

    /// The scene of a folder's snapshot; `None` if there is no snapshot.
    ///
    /// # Errors
    /// The errors of [`read_json`].
    pub(super) fn scene(folder: &Path) -> Result<Option<Scene>> {
        #[derive(Deserialize)]
        struct Planned {
            plan: Plan,
        }
        #[derive(Deserialize)]
        struct Plan {
            #[serde(with = "toml")]
            scene: Scene,
        }
        let path = folder.join(SNAPSHOT);
        if !path.exists() {
            return Ok(None);
        }
        let read: Planned = read_json(&path, FORMAT)?;
        Ok(Some(read.plan.scene))
    }

    /// A folder's snapshot.
    ///
    /// # Errors
    /// The errors of [`read_json`]; [`Error::Read`] for a folder that is not a run.
    pub(super) fn read(folder: &Path) -> Result<Snapshot<'static>> {
        let path = folder.join(SNAPSHOT);
        if !path.exists() {
            return Err(no_run(folder, SNAPSHOT));
        }
        read_json(&path, FORMAT)
    }
}

/// The plan in the bytes of a snapshot, after all checks of resuming. Messages name `path`. `accept`
/// may refuse a plan before any memory of its size is allocated.
///
/// # Errors
/// The errors of [`resume`](super::resume) about the snapshot, and those of `accept`.
pub fn check(
    path: &Path,
    bytes: &[u8],
    accept: impl Fn(&RunPlan) -> Result<()>,
) -> Result<RunPlan> {
    let snapshot: Snapshot = parse_json(path, bytes, FORMAT)?;
    accept(&snapshot.plan)?;
    if snapshot.progress.is_none() {
        return Ok(snapshot.plan.into_owned());
    }
    let codesign = CoDesign::new(&snapshot.plan.scene)?;
    snapshot.unpack(path, &codesign).map(|(plan, _)| plan)
}
