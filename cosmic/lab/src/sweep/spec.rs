//! What a sweep consists of: a TOML file with trials, or scenes by their names. Settings and seeds can be added.

use super::{Axis, Combination, Plan, Trial, combinations};
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::reading::{read_whole, text_of};
use cosmic::record::snapshot::SavedScene;
use cosmic::scene::{Scene, TomlFile};
use serde::{Deserialize, de::IgnoredAny};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::Path;

/// Settings and seeds that the user adds to a sweep.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// Settings of all scenes, each written as `KEY=V,V…`. Several values make an axis of the grid.
    pub set: Vec<String>,
    /// The number of seeds in place of the file's number.
    pub seeds: Option<NonZeroUsize>,
    /// The first seed in place of the file's.
    pub first_seed: Option<u64>,
    /// The number of iterations in place of the file's number.
    pub iterations: Option<NonZeroUsize>,
}

/// The key of a sweep's file for the grid.
const GRID: &str = "grid";

/// The keys of a sweep's file. `docs/files.md` has their meanings.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Keys {
    seeds: Option<NonZeroUsize>,
    first_seed: u64,
    iterations: Option<NonZeroUsize>,
    grid: Map<String, Value>,
    variants: Vec<Variant>,
    trials: Vec<TrialKeys>,
}

/// Settings with which all trials are run once more.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Variant {
    name: String,
    title: Option<String>,
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
    published: Option<f64>,
    #[serde(default)]
    variants: Vec<String>,
    #[serde(rename = "settings")]
    _settings: Option<IgnoredAny>,
}

/// Returns the plan of a sweep. `sources` is the path of the file of a sweep, or any number of built-in scenes and scene
/// files.
///
/// # Errors
/// [`Malformed`](Error::Malformed) for a file that is not TOML, has an unknown key or a malformed grid, or uses a variant
/// that it does not define or a scene that does not exist; the errors of reading and changing the scenes;
/// [`Usage`](Error::Usage) for a malformed option, for two trials of the same name, and for too many runs.
pub fn read(sources: &[String], overrides: &Overrides, registry: &Registry) -> Result<Plan> {
    let added = overrides.set.iter().map(|setting| Axis::parse(setting));
    let added: Vec<Axis> = added.collect::<Result<_>>()?;
    let text = match sources {
        [source] => text_of_sweep(source, registry)?,
        _ => None,
    };
    let file = text.as_ref().map(|text| TomlFile::parse(&sources[0], text));
    let file = file.transpose()?;
    let (keys, drafts) = match &file {
        Some(file) => {
            let keys = file.read()?;
            let drafts = trials(file, &sources[0], &keys, registry)?;
            (keys, drafts)
        }
        None => {
            let drafts = sources.iter().map(|source| of_source(source, registry));
            (Keys::default(), drafts.collect::<Result<_>>()?)
        }
    };
    let plan = || {
        let iterations = overrides.iterations.or(keys.iterations);
        let plan = Plan {
            first_seed: overrides.first_seed.unwrap_or(keys.first_seed),
            seeds: (overrides.seeds.or(keys.seeds)).unwrap_or(NonZeroUsize::MIN),
            trials: on_grid(file.as_ref(), &keys, &drafts, &added, iterations)?,
        };
        plan.check_shape().map(|()| plan)
    };
    plan().map_err(|error| match error {
        Error::Usage(says) if file.is_some() => Error::Usage(format!("{}: {says}", sources[0])),
        error => error,
    })
}

/// The text of a sweep's file; `None` if `source` is a scene.
fn text_of_sweep(source: &str, registry: &Registry) -> Result<Option<String>> {
    if registry.scene(source).is_some() || !Path::new(source).is_file() {
        return Ok(None);
    }
    let bytes = read_whole(source.as_ref())?;
    let text = text_of(source, &bytes)?;
    // A malformed file counts as a scene, whose reader shows the mistake.
    let is_of_sweep = TomlFile::parse(source, text).is_ok_and(|file| file.is_of_sweep());
    Ok(is_of_sweep.then(|| text.to_owned()))
}

/// A trial before it is multiplied by the grid.
struct Draft {
    name: String,
    title: String,
    published: Option<f64>,
    scene: Scene,
}

fn of_source(source: &str, registry: &Registry) -> Result<Draft> {
    Ok(Draft {
        name: stem(source),
        title: stem(source),
        published: None,
        scene: registry.load(source)?,
    })
}

/// The trials of a file, once for each variant.
fn trials(file: &TomlFile, path: &str, keys: &Keys, registry: &Registry) -> Result<Vec<Draft>> {
    let names: Vec<String> = keys.variants.iter().map(|v| v.name.clone()).collect();
    for (k, trial) in keys.trials.iter().enumerate() {
        file.check_names(&format!("trials[{k}].variants"), &trial.variants, &names)?;
    }
    // A file without variants has each trial once.
    let variants = (0..names.len()).map(Some);
    let variants = variants.chain(names.is_empty().then_some(None));
    let (mut all, none) = (Vec::new(), BTreeMap::new());
    for variant in variants {
        for (t, trial) in keys.trials.iter().enumerate() {
            let variant = variant.map(|v| (v, &keys.variants[v]));
            let is_of = |(_, variant): (usize, &Variant)| trial.variants.contains(&variant.name);
            if !trial.variants.is_empty() && !variant.is_some_and(is_of) {
                continue;
            }
            let mut scene = scene_of(file, t, &trial.scene, path, registry)?;
            let mut name = trial.name.clone().unwrap_or_else(|| stem(&trial.scene));
            let mut title = trial.title.clone().unwrap_or_else(|| name.clone());
            if let Some((v, variant)) = variant {
                scene = file.change(&scene, &format!("variants[{v}].settings"), &none)?;
                name = format!("{}-{name}", variant.name);
                title = format!(
                    "{}: {title}",
                    variant.title.as_ref().unwrap_or(&variant.name)
                );
            }
            scene = file.change(&scene, &format!("trials[{t}].settings"), &none)?;
            all.push(Draft {
                name,
                title,
                published: trial.published,
                scene,
            });
        }
    }
    Ok(all)
}

/// Reads the scene of trial number `t`. A name that is not that of a scene is a file beside the sweep's file.
fn scene_of(
    file: &TomlFile,
    t: usize,
    name: &str,
    path: &str,
    registry: &Registry,
) -> Result<Scene> {
    let beside = Path::new(path).with_file_name(name);
    if registry.scene(name).is_some() {
        return registry.load(name);
    }
    if !beside.exists() {
        let says = "is neither a built-in scene nor a file beside this one:";
        return Err(file.wrong(&format!("trials[{t}].scene"), says, &registry.hint(name)));
    }
    registry.read(&beside)
}

fn stem(scene: &str) -> String {
    let stem = Path::new(scene).file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// Combines every trial with every combination of the values of the grid of `file` and of `added`. The new trials have
/// names like `earth+friction=0.6+gravity=9.81`.
fn on_grid(
    file: Option<&TomlFile>,
    keys: &Keys,
    drafts: &[Draft],
    added: &[Axis],
    iterations: Option<NonZeroUsize>,
) -> Result<Vec<Trial>> {
    let of_file = file.map(|file| Axis::of_table(file, GRID, &keys.grid));
    let of_file = of_file.transpose()?.unwrap_or_default();
    let axes = [&of_file[..], added].concat();
    let grid = combinations(&axes)?;
    let swept = axes.iter().filter(|axis| axis.is_swept()).map(Axis::key);
    let swept: Vec<&str> = swept.collect();
    let mut trials = Vec::new();
    for draft in drafts {
        let mut known = BTreeMap::new();
        for combination in &grid {
            let mut scene = match file {
                Some(file) => file.change(&draft.scene, GRID, &combination.chosen)?,
                None => draft.scene.clone(),
            };
            scene = scene.set(&combination.settings[of_file.len()..])?;
            let autos: Vec<bool> = combination.settings.iter().map(|s| is_auto(s)).collect();
            // All values count, because a key may be spelt in several ways too.
            let values: Vec<String> = (scene.settings().into_iter())
                .map(|setting| setting.value)
                .collect();
            if let Some(same) = known.insert((values, autos), combination) {
                return Err(Error::Usage(same_trial(same, combination)));
            }
            if let Some(iterations) = iterations {
                scene = scene.fitted(iterations)?;
            }
            trials.push(Trial {
                name: format!("{}{}", draft.name, combination.suffix),
                title: format!("{}{}", draft.title, combination.suffix),
                published: draft.published,
                swept: (swept_values(&scene, &swept).into_iter())
                    .map(|(key, value)| (key, as_json(&value)))
                    .collect(),
                scene: without_comments(&scene),
            });
        }
    }
    Ok(trials)
}

/// The keys in `swept`, in the order of the scene, and their values as the scene writes them.
fn swept_values(scene: &Scene, swept: &[&str]) -> Vec<(String, String)> {
    let settings = scene.settings().into_iter();
    let settings = settings.filter(|setting| swept.contains(&&setting.key[..]));
    settings
        .map(|setting| (setting.key, setting.value))
        .collect()
}

/// Whether a setting lets the program choose the value. It is not the same as the value that the program chooses.
fn is_auto(setting: &str) -> bool {
    let value = setting.split_once('=').map_or("", |(_, value)| value);
    value.trim().trim_matches(['"', '\'']) == "auto"
}

/// Says that two combinations are one trial, because they spell the same values in different ways.
fn same_trial(one: &Combination, other: &Combination) -> String {
    let both = one.settings.iter().zip(&other.settings);
    let spelt: Vec<String> = both
        .filter(|(one, other)| one != other)
        .map(|(one, other)| format!("`{one}` and `{other}`"))
        .collect();
    format!(
        "{} are the same setting; give each value once",
        spelt.join(", ")
    )
}

/// The scene as the sweep's file contains it. Comments are nine tenths of the text, and a sweep may have thousands of
/// scenes.
fn without_comments(scene: &Scene) -> SavedScene {
    let mut saved = SavedScene::from(scene);
    let lines = saved.text.lines();
    let lines = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
    saved.text = lines.map(|line| format!("{line}\n")).collect();
    saved
}

/// The value of a scene's key. Numbers, booleans, lists of them and most strings are written alike in TOML and JSON.
fn as_json(written: &str) -> Value {
    let value = serde_json::from_str(written);
    value.unwrap_or_else(|_| Value::from(written.trim_matches(['"', '\''])))
}
