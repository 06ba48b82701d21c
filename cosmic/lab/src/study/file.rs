//! The TOML file of a study: scenes, settings, and published numbers to compare with.

use crate::export::mujoco::MOST_FRICTION;
use crate::report::PICTURES;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::scene::{BUILTIN, Scene, TomlFile};
use serde::{Deserialize, de::IgnoredAny};
use std::borrow::Cow;
use std::num::NonZeroUsize;
use std::path::Path;

/// The studies of this project: their names, and their files in the folder `studies`.
const OWN: [(&str, &str); 4] = [
    ("paper", include_str!("../../studies/paper.toml")),
    ("ablation", include_str!("../../studies/ablation.toml")),
    ("findings", include_str!("../../studies/findings.toml")),
    ("transfer", include_str!("../../studies/transfer.toml")),
];

/// The file of a study, read and checked.
#[derive(Clone, Debug)]
pub struct StudyFile {
    /// The study's name: the file's name without its extension.
    pub name: String,
    /// The user's argument: the name of a built-in study, or the path of a file.
    pub path: String,
    text: String,
    pub(super) keys: Keys,
}

/// The keys of a study's file. `docs/files.md` has their meanings.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct Keys {
    pub(super) title: String,
    pub(super) about: String,
    seeds: Option<NonZeroUsize>,
    pub(super) mujoco: Vec<f64>,
    pub(super) pictures: Vec<String>,
    pub(super) variants: Vec<Variant>,
    /// True if the file defines no variants. The study then has a single variant, whose name is the study's name.
    #[serde(skip)]
    is_plain: bool,
    trials: Vec<TrialKeys>,
    pub(super) questions: Vec<Question>,
}

/// A variant of the study: settings with which all trials are run once more. The document has a separate table for each
/// variant.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Variant {
    pub(super) name: String,
    pub(super) title: Option<String>,
    #[serde(default)]
    pub(super) about: String,
    /// Makes the parser accept the key `settings`. [`TomlFile::change`] reads its value.
    #[serde(rename = "settings")]
    _settings: Option<IgnoredAny>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct TrialKeys {
    scene: String,
    name: Option<String>,
    title: Option<String>,
    paper: Option<f64>,
    #[serde(default)]
    variants: Vec<String>,
    #[serde(rename = "settings")]
    _settings: Option<IgnoredAny>,
}

/// A question about two groups of trials. The answer is the change of the mean displacement from the group `from` to
/// the group `to`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Question {
    pub(super) ask: String,
    pub(super) from: Vec<String>,
    pub(super) to: Vec<String>,
    #[serde(default)]
    pub(super) paper: String,
}

/// One experiment of a study. It is run once with every seed.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    pub(super) name: String,
    /// The name of the table that shows the trial. It is the name of the trial's variant, or of the study if there are
    /// no variants.
    pub(super) table: String,
    pub(super) title: String,
    /// The published displacement along the ground, m.
    pub(super) paper: Option<f64>,
    pub(super) scene: Scene,
}

/// A user's file with settings for all built-in scenes of a study. The settings are new defaults: a key that a scene or
/// the study sets keeps its value. Without such a file, both texts are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Base {
    /// The file's name, which messages show.
    pub file: String,
    /// The content of the file, in TOML.
    pub text: String,
}

impl StudyFile {
    /// Reads one of the project's studies by its name, or a study's file by its path. The scenes are read later, when
    /// the study is planned.
    ///
    /// # Errors
    /// The errors of [`Scene::text`]; [`Error::Malformed`] for a file that is not TOML, has an unknown key, or uses a
    /// name that it does not define.
    pub fn load(path: &str) -> Result<Self> {
        let text = match OWN.iter().find(|(name, _)| *name == path) {
            Some((_, text)) => (*text).to_owned(),
            None => Scene::text(path.as_ref())?,
        };
        let name = Path::new(path).file_stem().unwrap_or_default();
        let file = TomlFile::parse(path, &text)?;
        let mut study = Self {
            name: name.to_string_lossy().into_owned(),
            path: path.to_owned(),
            keys: file.read()?,
            text: text.clone(),
        };
        if study.keys.variants.is_empty() {
            let name = study.name.clone();
            study.keys.is_plain = true;
            study.keys.variants.push(Variant {
                name,
                ..Variant::default()
            });
        }
        study.check(&file).map(|()| study)
    }

    /// The number of seeds if the user does not give one: the number in the file, or else 16.
    pub fn seeds(&self) -> NonZeroUsize {
        let usual = const { NonZeroUsize::new(16).unwrap() };
        self.keys.seeds.unwrap_or(usual)
    }

    /// The names of all trials, each with the index of its variant and the index of its entry in the file.
    fn entries(&self) -> Vec<(String, usize, usize)> {
        let mut entries = Vec::new();
        for (v, variant) in self.keys.variants.iter().enumerate() {
            for (t, trial) in self.keys.trials.iter().enumerate() {
                let stem = Path::new(&trial.scene).file_stem().unwrap_or_default();
                let name = trial
                    .name
                    .as_ref()
                    .map_or(stem.to_string_lossy(), Cow::from);
                let name = match self.keys.is_plain {
                    true => name.into_owned(),
                    false => format!("{}-{name}", variant.name),
                };
                if trial.variants.is_empty() || trial.variants.contains(&variant.name) {
                    entries.push((name, v, t));
                }
            }
        }
        entries
    }

    /// Checks that every name that the file uses is defined, and that the frictions are in range.
    fn check(&self, file: &TomlFile) -> Result<()> {
        let keys = &self.keys;
        let pictures = PICTURES.map(|(name, _)| name.to_owned());
        file.check_names("pictures", &keys.pictures, &pictures)?;
        let variants = keys.variants.iter().map(|variant| &variant.name);
        let variants: Vec<String> = variants.cloned().collect();
        for (k, trial) in keys.trials.iter().enumerate() {
            file.check_names(&format!("trials[{k}].variants"), &trial.variants, &variants)?;
        }
        let trials: Vec<_> = self.entries().into_iter().map(|(name, ..)| name).collect();
        for (k, question) in keys.questions.iter().enumerate() {
            file.check_names(&format!("questions[{k}].from"), &question.from, &trials)?;
            file.check_names(&format!("questions[{k}].to"), &question.to, &trials)?;
        }
        let is_wrong = |friction: &f64| !(f64::MIN_POSITIVE..=MOST_FRICTION).contains(friction);
        keys.mujoco.iter().position(is_wrong).map_or(Ok(()), |k| {
            let allowed = format!("allowed: a number above 0 and at most {MOST_FRICTION}");
            Err(file.wrong(&format!("mujoco[{k}]"), "is out of range:", &allowed))
        })
    }

    /// Returns the trials in the order of the tables. The defaults of built-in scenes come from `base`.
    ///
    /// # Errors
    /// The errors of [`Scene::load`] and [`Scene::with`].
    pub(super) fn trials(&self, base: &Base, registry: &Registry) -> Result<Vec<Trial>> {
        let file = TomlFile::parse(&self.path, &self.text)?;
        let trial = |(name, v, t): (String, usize, usize)| {
            let keys = &self.keys.trials[t];
            let mut changes = [("variants", v), ("trials", t)].into_iter();
            let change = |scene: Scene, (list, k): (&str, usize)| {
                file.change(&scene, &format!("{list}[{k}].settings"))
            };
            let scene = self.scene(&keys.scene, base, registry);
            let scene = scene.and_then(|scene| changes.try_fold(scene, change));
            // The error shows a place in the study's file, but the user's `base` may be the cause.
            let scene = scene.map_err(|error| match &base.file[..] {
                "" => error,
                file => Error::Usage(format!(
                    "the settings of {file} do not fit those of the study: {}",
                    error.within()
                )),
            });
            Ok(Trial {
                title: keys.title.clone().unwrap_or_else(|| name.clone()),
                name,
                table: self.keys.variants[v].name.clone(),
                paper: keys.paper,
                scene: scene?,
            })
        };
        self.entries().into_iter().map(trial).collect()
    }

    /// Reads the scene of a trial by its name. If it is a built-in scene, its defaults come from `base`. Any other name
    /// stands for a scene of the registry or for a file beside the study's file.
    fn scene(&self, name: &str, base: &Base, registry: &Registry) -> Result<Scene> {
        if let Some(builtin) = BUILTIN.iter().find(|builtin| builtin.name == name) {
            let below = registry.load("stability")?.with(&base.file, &base.text)?;
            return builtin.over(&below);
        }
        if !base.file.is_empty() {
            let says = format!(
                "only built-in scenes can have a base, but `{name}` is not a built-in scene"
            );
            return Err(Error::Usage(says));
        }
        match registry.scene(name) {
            Some(_) => registry.load(name),
            None => registry.read(&Path::new(&self.path).with_file_name(name)),
        }
    }
}
