//! A study's file: scenes, settings, and published numbers to compare with.

use crate::export::mujoco::MOST_FRICTION;
use crate::report::PICTURES;
use cosmic::error::{Error, Result};
use cosmic::scene::{BUILTIN, Scene, TomlFile, named};
use serde::{Deserialize, Serialize, de::IgnoredAny};
use std::num::NonZeroUsize;
use std::path::Path;

/// The studies of this project: the files of these names in `studies`.
const OWN: [(&str, &str); 4] = [
    ("paper", include_str!("../../studies/paper.toml")),
    ("ablation", include_str!("../../studies/ablation.toml")),
    ("findings", include_str!("../../studies/findings.toml")),
    ("transfer", include_str!("../../studies/transfer.toml")),
];

/// A study's file, read and checked.
#[derive(Clone, Debug)]
pub struct StudyFile {
    /// The study's name: that of the file without its extension.
    pub name: String,
    /// The name or the path that the user gave.
    pub path: String,
    text: String,
    pub(super) keys: Keys,
}

/// The keys of a study's file. `docs/files.md` has their meanings.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Keys {
    pub(super) title: String,
    #[serde(default)]
    pub(super) about: String,
    seeds: Option<NonZeroUsize>,
    #[serde(default)]
    pub(super) mujoco: Vec<f64>,
    #[serde(default)]
    pub(super) pictures: Vec<String>,
    #[serde(default)]
    variants: Vec<Variant>,
    trials: Vec<TrialKeys>,
    #[serde(default)]
    pub(super) questions: Vec<Question>,
}

/// Settings with which all trials are run: a table of the document.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Variant {
    pub(super) name: String,
    pub(super) title: Option<String>,
    #[serde(default)]
    pub(super) about: String,
    /// Read by [`TomlFile::change`].
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
    variants: Option<Vec<String>>,
    #[serde(rename = "settings")]
    _settings: Option<IgnoredAny>,
}

/// A question that the change from some trials to others answers.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Question {
    pub(super) ask: String,
    pub(super) from: Vec<String>,
    pub(super) to: Vec<String>,
    #[serde(default)]
    pub(super) paper: String,
}

/// One experiment, to be run with every seed.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Trial {
    /// Its name in files.
    pub(super) name: String,
    /// The table that it belongs to: its variant, or the study.
    pub(super) table: String,
    pub(super) title: String,
    /// The published displacement along the ground, m.
    pub(super) paper: Option<f64>,
    #[serde(skip)]
    pub(super) scene: Scene,
}

/// Settings under the built-in scenes of a study. Without any, both texts are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Base {
    /// The file's name, for messages.
    pub file: String,
    /// Its text, TOML.
    pub text: String,
}

impl StudyFile {
    /// The study of this project with a name, else that of a file.
    ///
    /// # Errors
    /// Those of [`Scene::text`] and [`parse`](Self::parse).
    pub fn load(path: &str) -> Result<Self> {
        match OWN.iter().find(|(name, _)| *name == path) {
            Some((_, text)) => Self::parse(path, text),
            None => Self::parse(path, &Scene::text(path.as_ref())?),
        }
    }

    /// Reads the text of a file. Its scenes are read when the study is planned.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a text that is not TOML, an unknown key, and a name that the file does not define.
    pub fn parse(path: &str, text: &str) -> Result<Self> {
        let name = Path::new(path).file_stem().unwrap_or_default();
        let file = TomlFile::parse(path, text)?;
        let study = Self {
            name: name.to_string_lossy().into_owned(),
            path: path.to_owned(),
            text: text.to_owned(),
            keys: file.read()?,
        };
        study.check(&file).map(|()| study)
    }

    /// The number of seeds, unless the user asks for another one.
    pub fn seeds(&self) -> NonZeroUsize {
        const SEEDS: NonZeroUsize = NonZeroUsize::new(16).unwrap();
        self.keys.seeds.unwrap_or(SEEDS)
    }

    /// The variants; one of the study's name if the file has none.
    pub(super) fn tables(&self) -> Vec<Variant> {
        let mut tables = self.keys.variants.clone();
        if tables.is_empty() {
            let name = self.name.clone();
            tables.push(Variant {
                name,
                ..Variant::default()
            });
        }
        tables
    }

    /// The names of the trials, each with the indices of its variant and of its entry in the file.
    fn entries(&self) -> Vec<(String, usize, usize)> {
        let mut entries = Vec::new();
        for (v, variant) in self.tables().iter().enumerate() {
            for (t, trial) in self.keys.trials.iter().enumerate() {
                let name = trial.name.as_ref().unwrap_or(&trial.scene);
                let variants = trial.variants.as_ref();
                if self.keys.variants.is_empty() {
                    entries.push((name.clone(), v, t));
                } else if variants.is_none_or(|variants| variants.contains(&variant.name)) {
                    entries.push((format!("{}-{name}", variant.name), v, t));
                }
            }
        }
        entries
    }

    /// Checks the names that refer to something, and the frictions.
    fn check(&self, file: &TomlFile) -> Result<()> {
        let keys = &self.keys;
        let pictures = PICTURES.map(|(name, _)| name.to_owned()).to_vec();
        let variants = keys
            .variants
            .iter()
            .map(|variant| variant.name.clone())
            .collect();
        let trials = self.entries().into_iter().map(|(name, ..)| name).collect();
        let mut lists = vec![("pictures".to_owned(), &keys.pictures, &pictures)];
        for (k, trial) in keys.trials.iter().enumerate() {
            let names = trial.variants.iter();
            lists.extend(names.map(|names| (format!("trials[{k}].variants"), names, &variants)));
        }
        for (k, question) in keys.questions.iter().enumerate() {
            lists.push((format!("questions[{k}].from"), &question.from, &trials));
            lists.push((format!("questions[{k}].to"), &question.to, &trials));
        }
        for (path, names, known) in lists {
            if let Some(k) = names.iter().position(|name| !known.contains(name)) {
                let allowed = format!("expected one of {}", known.join(", "));
                return Err(file.wrong(&format!("{path}[{k}]"), "is unknown:", &allowed));
            }
        }
        let is_wrong = |friction: &f64| !(0.0 < *friction && *friction <= MOST_FRICTION);
        keys.mujoco.iter().position(is_wrong).map_or(Ok(()), |k| {
            let allowed = format!("allowed: a number above 0 and at most {MOST_FRICTION}");
            Err(file.wrong(&format!("mujoco[{k}]"), "is out of range:", &allowed))
        })
    }

    /// The trials over the settings of `base`, table by table.
    ///
    /// # Errors
    /// Those of [`Scene::load`] and [`Scene::with`].
    pub(super) fn trials(&self, base: &Base) -> Result<Vec<Trial>> {
        let (file, tables) = (TomlFile::parse(&self.path, &self.text)?, self.tables());
        let trial = |(name, v, t): (String, usize, usize)| {
            let keys = &self.keys.trials[t];
            let changes = [
                format!("variants[{v}].settings"),
                format!("trials[{t}].settings"),
            ];
            let scene = self.scene(&keys.scene, base);
            let change = |scene: Scene, path: &String| file.change(&scene, path);
            let scene = scene.and_then(|scene| changes.iter().try_fold(scene, change));
            // The place is in the study's file, the cause may be in the base.
            let scene = scene.map_err(|error| match &base.file[..] {
                "" => error,
                file => Error::Usage(format!(
                    "the settings of {file} do not go with the study's: {}",
                    error.within()
                )),
            });
            Ok(Trial {
                title: keys.title.clone().unwrap_or_else(|| name.clone()),
                name,
                table: tables[v].name.clone(),
                paper: keys.paper,
                scene: scene?,
            })
        };
        self.entries().into_iter().map(trial).collect()
    }

    /// A built-in scene over the base, else a scene of the program's or of a file beside the study's.
    fn scene(&self, name: &str, base: &Base) -> Result<Scene> {
        if let Some(builtin) = BUILTIN.iter().find(|builtin| builtin.name == name) {
            let below = Scene::paper().with(&base.file, &base.text)?;
            return below.with(name, &builtin.changes());
        }
        if !base.file.is_empty() {
            let says = format!("only built-in scenes can have a base, not `{name}`");
            return Err(Error::Usage(says));
        }
        match named(name) {
            Some(_) => Scene::load(name),
            None => Scene::read(&Path::new(&self.path).with_file_name(name)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Base, OWN, StudyFile, Trial};
    use cosmic::codesign::CoDesign;
    use cosmic::scene::Scene;

    fn trials(name: &str, base: &str) -> cosmic::Result<Vec<Trial>> {
        let [file, text] =
            [if base.is_empty() { "" } else { "base.toml" }, base].map(str::to_owned);
        StudyFile::load(name)?.trials(&Base { file, text })
    }

    #[test]
    fn the_strict_table_departs_in_nothing_and_the_other_is_the_built_in_scenes() {
        for trial in trials("paper", "").unwrap() {
            let departures = trial.scene.departures();
            assert_eq!(
                departures.is_empty(),
                trial.table == "strict",
                "{departures:?}"
            );
            if let Some(name) = trial.name.strip_prefix("default-") {
                assert_eq!(trial.scene, Scene::load(name).unwrap());
            }
        }
    }

    /// So the eight trials of the ablation are all combinations.
    #[test]
    fn every_trial_can_begin_and_is_not_another() {
        for (name, _) in OWN {
            let trials = trials(name, "").unwrap();
            for (k, trial) in trials.iter().enumerate() {
                CoDesign::new(&trial.scene).unwrap().begin(0).unwrap();
                let same = |other: &Trial| other.scene == trial.scene;
                assert!(!trials[..k].iter().any(same), "{}", trial.name);
            }
        }
    }

    #[test]
    fn a_base_lies_under_every_built_in_scene() {
        for trial in trials("ablation", "[physics]\ngravity = 1.5\n").unwrap() {
            assert_eq!(trial.scene.physics.gravity, 1.5);
        }
        let error = trials("paper", "[physics]\ngravty = 1")
            .unwrap_err()
            .to_string();
        assert!(error.contains("base.toml:2:1"), "{error}");
    }
}
