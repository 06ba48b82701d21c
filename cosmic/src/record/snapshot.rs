//! `snapshot.json`: the plan and the state of a run, which is all that resuming needs.

use super::files::{no_run, read_json, write_json};
use crate::design::Design;
use crate::error::{Error, Result};
use crate::format::{Format, parse_json};
use crate::lattice::Truss;
use crate::reading::{placed, read_whole};
use crate::registry::Registry;
use crate::scene::{Scene, TrussFile};
use crate::search::{CoDesign, Progress};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::Arc;

/// The format of a snapshot.
const FORMAT: Format = Format::new("cosmic-snapshot", 1);

/// The name of the snapshot in the folder of a run.
pub const SNAPSHOT: &str = "snapshot.json";

/// The plan of a run, or of several starts. In memory, the type `S` of its scene is [`Scene`]; in files, it is
/// [`SavedScene`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunPlan<S = Scene> {
    /// The name of the scene.
    pub name: String,
    /// The scene.
    pub scene: S,
    /// The seed of the run, or the first seed of several starts.
    pub seed: u64,
    /// The number of starts. Their seeds are consecutive.
    pub starts: NonZeroUsize,
    /// The run stops after this number of iterations, in the middle of its phases; `None` for all iterations of the
    /// scene. The robot of an unfinished run is delivered so; [`fitted`](Self::fitted) makes a run that is short but
    /// whole.
    pub iterations: Option<NonZeroUsize>,
}

impl<S> RunPlan<S> {
    /// A copy of this plan whose scene is `scene`. The scene may have another form.
    fn with_scene<T>(&self, scene: T) -> RunPlan<T> {
        RunPlan {
            name: self.name.clone(),
            scene,
            seed: self.seed,
            starts: self.starts,
            iterations: self.iterations,
        }
    }
}

impl RunPlan<SavedScene> {
    /// Reads the scene.
    ///
    /// # Errors
    /// The errors of [`SavedScene::read`].
    pub fn read(&self, registry: &Registry) -> Result<RunPlan> {
        let scene = self.scene.read("plan.scene", registry)?;
        Ok(self.with_scene(scene))
    }
}

impl RunPlan {
    /// The plan in the form in which it is saved.
    pub fn saved(&self) -> RunPlan<SavedScene> {
        self.with_scene(SavedScene::from(&self.scene))
    }

    /// The plan for one start that does all iterations of the scene.
    pub fn new(name: &str, scene: Scene, seed: u64) -> Self {
        Self {
            name: name.to_owned(),
            scene,
            seed,
            starts: NonZeroUsize::MIN,
            iterations: None,
        }
    }

    /// This plan with the phases of its scene fitted into so many iterations; `None` for those of the scene. A run that
    /// begins with the layout `from` has only its fine-tuning, which gets all iterations.
    ///
    /// # Errors
    /// [`Error::Usage`] for more iterations than a schedule may have.
    pub fn fitted(
        mut self,
        iterations: Option<NonZeroUsize>,
        from: Option<&Design<[f64; 3]>>,
    ) -> Result<Self> {
        if let Some(iterations) = iterations {
            self.scene = match from {
                Some(Design::Layout(_)) => self.scene.fitted_after_snap(iterations)?,
                _ => self.scene.fitted(iterations)?,
            };
        }
        Ok(self)
    }

    /// Checks that this plan, the plan of the run in `folder`, is equal to `expected`. Only `physics.unstable_step` may
    /// differ, because [`allow_unstable`](super::allow_unstable) changes it for a run that has begun.
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
            "{}: the folder holds a run of the scene `{}` with the seed {}, but the run of the scene \
             `{}` with the seed {} is expected (settings or the number of iterations may also differ); \
             move the folder elsewhere",
            folder.display(),
            self.name,
            self.seed,
            expected.name,
            expected.seed
        )))
    }

    /// The last iteration of a run that begins with the scene's initial design.
    pub fn last_iteration(&self) -> usize {
        self.last_after(0)
    }

    /// The last iteration of a run whose first iteration is `entered + 1`.
    pub(super) fn last_after(&self, entered: usize) -> usize {
        let all = self.scene.schedule.iterations;
        let last = |limit: NonZeroUsize| entered.saturating_add(limit.get()).min(all);
        self.iterations.map_or(all, last)
    }
}

/// The form in which JSON files contain a scene: the text of the scene, and the truss of its lattice if there is one.
/// So no other file is needed to read the scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedScene {
    /// The text of the scene, which is TOML.
    pub text: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    truss: Option<Truss>,
}

impl From<&Scene> for SavedScene {
    fn from(scene: &Scene) -> Self {
        Self {
            text: scene.to_run_toml(),
            truss: scene.lattice.file.truss().map(|truss| Truss::clone(truss)),
        }
    }
}

impl SavedScene {
    /// Reads the scene. Errors begin with `place`, the key of the scene in its file, such as `plan.scene`.
    ///
    /// # Errors
    /// [`Error::Usage`] with the line and the column within the text.
    pub fn read(&self, place: &str, registry: &Registry) -> Result<Scene> {
        let truss = self.truss.clone();
        let truss = truss.map(|truss| TrussFile::new(TrussFile::COPY, Arc::new(truss)));
        let scene = registry.parse_with("scene", &self.text, truss);
        scene.map_err(|error| {
            // The report of a malformed file has several lines; one line is enough here.
            let says = match error {
                Error::Malformed {
                    line,
                    column,
                    message,
                    ..
                } => format!("the scene, line {line}, column {column}: {message}"),
                error => error.to_string(),
            };
            Error::Usage(format!("`{place}`: {says}"))
        })
    }
}

/// The plan and the state of a run.
#[derive(Clone, Debug)]
pub(super) struct Snapshot {
    pub(super) plan: RunPlan,
    /// Wall time of the run so far without interruptions, in seconds.
    pub(super) seconds: f64,
    /// The state of the optimisation. `None` for several starts, because each start has its own snapshot.
    pub(super) progress: Option<Progress>,
}

/// The contents of a snapshot file.
#[derive(Serialize, Deserialize)]
struct SnapshotFile<'a> {
    plan: RunPlan<SavedScene>,
    seconds: f64,
    progress: Option<Cow<'a, Progress>>,
}

impl SnapshotFile<'_> {
    /// Parses the scene of the plan, and returns the snapshot. `path` and `bytes` are the path and the contents of the
    /// snapshot file; they are needed only for errors.
    fn read(self, path: &Path, bytes: &[u8], registry: &Registry) -> Result<Snapshot> {
        Ok(Snapshot {
            plan: in_file(path, bytes, self.plan.read(registry))?,
            seconds: self.seconds,
            progress: self.progress.map(Cow::into_owned),
        })
    }
}

/// Adds the position in the snapshot file to an error about the scene in that file.
fn in_file<T>(path: &Path, bytes: &[u8], result: Result<T>) -> Result<T> {
    let (file, text) = (path.display().to_string(), String::from_utf8_lossy(bytes));
    result.map_err(|error| placed(&file, &text, error))
}

impl Snapshot {
    /// Writes a plan and a state as the snapshot of a folder, and replaces an older snapshot.
    pub(super) fn save(
        folder: &Path,
        plan: &RunPlan,
        seconds: f64,
        progress: Option<&Progress>,
    ) -> Result<()> {
        let file = SnapshotFile {
            plan: plan.saved(),
            seconds,
            progress: progress.map(Cow::Borrowed),
        };
        write_json(&folder.join(SNAPSHOT), FORMAT, &file)
    }

    /// Writes this snapshot to a folder, and replaces an older snapshot.
    pub(super) fn write(&self, folder: &Path) -> Result<()> {
        Self::save(folder, &self.plan, self.seconds, self.progress.as_ref())
    }

    /// Checks that the snapshot fits the optimisation, and returns its plan and state. Errors name `file`.
    ///
    /// # Errors
    /// [`Error::Usage`] if the optimisation has another scene or another loss; the errors of [`CoDesign::first`] and
    /// [`Progress::fits`].
    pub(super) fn unpack(self, file: &Path, codesign: &CoDesign) -> Result<(RunPlan, Progress)> {
        let plan = self.plan;
        if *codesign.scene() != plan.scene {
            return Err(Error::Usage(format!(
                "{}: the run has a different scene from this optimisation; resume it with the scene that it was started with",
                file.display()
            )));
        }
        let first = codesign.first(plan.seed)?;
        let progress = self.progress.unwrap_or_else(|| first.clone());
        if progress.own_loss != first.own_loss {
            let file = file.display();
            return Err(if progress.own_loss {
                Error::OwnLoss {
                    file: file.to_string(),
                    remedy: "can continue the run with record::resume_with",
                }
            } else {
                Error::Usage(format!(
                    "{file}: the run began with the objective of its scene, but the optimisation has another loss; \
                    continue without a loss"
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
                "{file}: `progress.entered` is {entered} after iteration {iteration}; it must be 0, or \
                 {snap_at} (the iteration of the snap) if the run has reached that iteration"
            )));
        }
        Ok((plan, progress))
    }

    /// Reads only the scene from the snapshot of a folder; `None` if there is no snapshot.
    ///
    /// # Errors
    /// Like [`read`](Self::read).
    pub(super) fn scene(folder: &Path, registry: &Registry) -> Result<Option<Scene>> {
        #[derive(Deserialize)]
        struct Planned {
            plan: RunPlan<SavedScene>,
        }
        let path = folder.join(SNAPSHOT);
        if !path.exists() {
            return Ok(None);
        }
        let bytes = read_whole(&path)?;
        let read: Planned = parse_json(&path, &bytes, FORMAT)?;
        in_file(&path, &bytes, read.plan.read(registry)).map(|plan| Some(plan.scene))
    }

    /// True if the run in a folder began with the caller's loss; false if there is no readable snapshot.
    pub(super) fn has_own_loss(folder: &Path) -> bool {
        #[derive(Deserialize)]
        struct Outline {
            progress: Option<OutlinedProgress>,
        }
        #[derive(Deserialize)]
        struct OutlinedProgress {
            #[serde(default)]
            own_loss: bool,
        }
        let outline: Result<Outline> = read_json(&folder.join(SNAPSHOT), FORMAT);
        let progress = outline.ok().and_then(|outline| outline.progress);
        progress.is_some_and(|progress| progress.own_loss)
    }

    /// Reads the snapshot of a folder.
    ///
    /// # Errors
    /// The errors of [`read_whole`] and [`parse_json`]; [`Error::Malformed`] for a malformed scene; [`Error::Read`] for
    /// a folder that is not a run.
    pub(super) fn read(folder: &Path, registry: &Registry) -> Result<Self> {
        let path = folder.join(SNAPSHOT);
        if !path.exists() {
            return Err(no_run(folder, SNAPSHOT));
        }
        let bytes = read_whole(&path)?;
        let file: SnapshotFile = parse_json(&path, &bytes, FORMAT)?;
        file.read(&path, &bytes, registry)
    }
}

/// Checks the bytes of a snapshot file in the same way as resuming does, and returns the plan. Errors name `path`.
/// `accept` may refuse a plan before memory is allocated for it.
///
/// # Errors
/// The errors of [`resume`](super::resume) about the snapshot, and those of `accept`.
pub fn check(
    path: &Path,
    bytes: &[u8],
    accept: impl Fn(&RunPlan) -> Result<()>,
) -> Result<RunPlan> {
    let file: SnapshotFile = parse_json(path, bytes, FORMAT)?;
    let snapshot = file.read(path, bytes, &Registry::default())?;
    accept(&snapshot.plan)?;
    if snapshot.progress.is_none() {
        return Ok(snapshot.plan);
    }
    let codesign = CoDesign::new(&snapshot.plan.scene)?;
    snapshot.unpack(path, &codesign).map(|(plan, _)| plan)
}
