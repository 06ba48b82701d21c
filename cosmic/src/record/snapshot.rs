//! `snapshot.json`: the plan and the state of a run, which is all that resuming needs.

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

/// The plan of a run, or of several starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunPlan {
    /// The name of the scene.
    pub name: String,
    /// The scene, which is TOML in the file.
    #[serde(with = "toml")]
    pub scene: Scene,
    /// The seed, or the first of several.
    pub seed: u64,
    /// The number of seeds.
    pub starts: NonZeroUsize,
    /// The most iterations of the run, or `None` for all iterations of the scene.
    pub iterations: Option<NonZeroUsize>,
    /// How several starts are searched.
    #[serde(default, skip_serializing_if = "Search::is_full")]
    pub search: Search,
}

/// How several starts are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Search {
    /// All starts are finished.
    #[default]
    Full,
    /// Successive halving: weak starts are dropped early, by `[search]` of the scene.
    Halving,
}

impl Search {
    fn is_full(&self) -> bool {
        *self == Self::Full
    }
}

impl RunPlan {
    /// A run of one start with all iterations of the scene.
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

    /// Checks that this plan, of the run in a folder, is the expected one. `physics.unstable_step` may differ, because
    /// [`allow_unstable`](super::allow_unstable) changes it for a run that has begun.
    pub(super) fn check_same(&self, expected: &Self, folder: &Path) -> Result<()> {
        let mut own = self.clone();
        own.scene.physics.unstable_step = expected.scene.physics.unstable_step;
        if own == *expected {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "{}: the folder holds another run (scene `{}`, seed {}) than expected (scene `{}`, seed {}, \
             perhaps with other settings or another number of iterations); move the folder elsewhere",
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

/// A scene in JSON: its text, and the truss of its lattice if there is one, so that no other file is needed.
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

    /// Writes the TOML of the scene as a string, or as an object that holds the truss too.
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

    /// Reads a scene that [`serialize`] wrote.
    ///
    /// # Errors
    /// The errors in the TOML, with line and column.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Scene, D::Error> {
        // With a visitor, errors have the position of the scene in the file.
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

    /// An error in one line; the report of a malformed file is longer.
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
    /// Wall time so far without interruptions, s.
    pub(super) seconds: f64,
    /// `None` for several starts, because each start has its own snapshot.
    pub(super) progress: Option<Cow<'a, Progress>>,
}

impl Snapshot<'_> {
    /// Replaces the snapshot in a folder.
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

    /// Replaces the snapshot in a folder by this one.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        write_json(&folder.join(SNAPSHOT), FORMAT, self)
    }

    /// The plan and the state, after a check that they fit the optimisation. Errors name `file`.
    pub(super) fn unpack(self, file: &Path, codesign: &CoDesign) -> Result<(RunPlan, Progress)> {
        let plan = self.plan.into_owned();
        if *codesign.scene() != plan.scene {
            return Err(Error::Usage(format!(
                "{}: the optimisation and the run have different scenes",
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
                    "{file}: the run is for the objective of its scene; it cannot continue with another loss"
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

    /// Reads the scene from the snapshot of a folder; `None` if there is no snapshot.
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

    /// Reads the snapshot of a folder.
    pub(super) fn read(folder: &Path) -> Result<Snapshot<'static>> {
        let path = folder.join(SNAPSHOT);
        if !path.exists() {
            return Err(no_run(folder, SNAPSHOT));
        }
        read_json(&path, FORMAT)
    }
}

/// Parses the plan of a snapshot and does all checks of resuming. Errors name `path`. `accept` may refuse a plan before
/// memory is allocated for it.
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
