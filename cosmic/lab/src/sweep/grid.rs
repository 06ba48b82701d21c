//! The grid of a plan: every combination of the values of some settings.

use super::{PlannedScene, SweptValue};
use cosmic::error::{Error, Result};
use cosmic::record::MOST_RUNS;
use cosmic::scene::Scene;
use serde_json::Value;
use std::collections::BTreeSet;

/// An axis of a grid: a key of a scene and the values that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct GridAxis {
    key: String,
    /// The values as TOML text, in the form that `--set` accepts.
    values: Vec<String>,
}

/// One point of the grid: a value for every key.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// The suffix for the scene's name, such as `+friction=0.6+gravity=9.81`; empty without a grid.
    pub suffix: String,
    /// The settings of this point of the grid, such as `physics.friction=0.6`.
    pub settings: Vec<String>,
}

/// The greatest length of a suffix, in bytes. The name of a run's folder consists of the scene's name, the suffix and
/// the seed, and may have at most 255 bytes.
const LONGEST: usize = 160;

/// Combines every scene with every combination of the grid's values. The new scenes have names like
/// `earth+friction=0.6+gravity=9.81`. Each text in `axes` is an axis of the grid, written as `KEY=V,V…`. First, all
/// scenes get the `settings`, each written as `KEY=VALUE`.
///
/// # Errors
/// [`Error::Usage`] for a malformed axis, for two axes with the same key, and for more combinations than a plan may
/// have runs; the errors of [`Scene::set`].
pub fn on_grid(
    scenes: &[(String, Scene)],
    settings: &[String],
    axes: &[String],
) -> Result<Vec<PlannedScene>> {
    let axes = axes.iter().map(|axis| GridAxis::parse(axis));
    let grid = combinations(&axes.collect::<Result<Vec<_>>>()?)?;
    let pairs = scenes
        .iter()
        .flat_map(|named| grid.iter().map(move |combination| (named, combination)));
    let planned = pairs.map(|((name, scene), combination)| {
        let settings = [settings, &combination.settings].concat();
        let scene = scene.set(&settings)?;
        Ok(PlannedScene {
            swept: swept(&scene, &combination.settings),
            ..PlannedScene::new(format!("{name}{}", combination.suffix), &scene)
        })
    });
    planned.collect()
}

/// Returns the keys in `settings`, which are written as `KEY=VALUE`, with the values that the scene has for these keys.
fn swept(scene: &Scene, settings: &[String]) -> Vec<SweptValue> {
    let known = scene.settings();
    let of = |setting: &String| {
        let (key, written) = setting.split_once('=')?;
        let as_read = known.iter().find(|known| known.key == key);
        let value = as_read.map_or(written, |known| &known.value);
        // Numbers, booleans, lists of numbers or booleans, and most strings are written alike in TOML and JSON.
        let value = serde_json::from_str(value);
        Some(SweptValue {
            key: key.to_owned(),
            value: value.unwrap_or_else(|_| Value::from(written.trim_matches(['"', '\'']))),
        })
    };
    settings.iter().filter_map(of).collect()
}

impl GridAxis {
    /// Reads `KEY=V,V…`. A comma within brackets, braces or quotes does not separate.
    ///
    /// # Errors
    /// [`Error::Usage`] for a text of another form, an empty value, or a repeated value.
    pub fn parse(text: &str) -> Result<Self> {
        let refuse = |says: &str| {
            Err(Error::Usage(format!(
                "--grid {text}: {says}; expected a key and its values, as in physics.friction=0.6,1"
            )))
        };
        let Some((key, values)) = text.split_once('=') else {
            return refuse("`=` is missing");
        };
        let key = key.trim();
        if key.is_empty() {
            return refuse("the key is missing");
        }
        let values = separated(values);
        let mut known = BTreeSet::new();
        for value in &values {
            if value.is_empty() {
                return refuse("a value is empty");
            }
            if !known.insert(value) {
                return refuse(&format!("the value {value} is repeated"));
            }
        }
        Ok(Self {
            key: key.to_owned(),
            values,
        })
    }

    /// The part of the key after the last dot, such as `friction` for `physics.friction`.
    fn short(&self) -> &str {
        self.key.rsplit('.').next().unwrap_or(&self.key)
    }
}

/// Splits a text at commas, except commas inside brackets or quotes.
fn separated(text: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quote) = (vec![String::new()], 0_usize, None);
    for c in text.chars() {
        match (quote, c) {
            (None, ',') if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            (None, '\'' | '"') => quote = Some(c),
            (Some(open), _) if open == c => quote = None,
            (None, '[' | '{') => depth += 1,
            (None, ']' | '}') => depth = depth.saturating_sub(1),
            _ => {}
        }
        parts.last_mut().expect("there is one part").push(c);
    }
    parts.iter().map(|part| part.trim().to_owned()).collect()
}

/// Returns every combination of the values of all axes. The values of the last axis change fastest.
///
/// # Errors
/// [`Error::Usage`] for two axes with the same key, and for more combinations than a plan may have runs.
pub fn combinations(axes: &[GridAxis]) -> Result<Vec<Combination>> {
    for (k, axis) in axes.iter().enumerate() {
        if axes[..k].iter().any(|other| other.key == axis.key) {
            return Err(Error::Usage(format!(
                "`{}` is in the grid twice; give all of its values in one --grid",
                axis.key
            )));
        }
    }
    let counts = axes.iter().map(|axis| axis.values.len());
    let count = counts.fold(1_usize, usize::saturating_mul);
    if count > MOST_RUNS {
        return Err(Error::Usage(format!(
            "the grid has {count} combinations, but a plan may have at most {MOST_RUNS} runs; give fewer values"
        )));
    }
    let mut all = vec![Combination {
        suffix: String::new(),
        settings: Vec::new(),
    }];
    for axis in axes {
        let is_other = |other: &GridAxis| other.key != axis.key && other.short() == axis.short();
        let is_ambiguous = axes.iter().any(is_other);
        let name = if is_ambiguous {
            &axis.key
        } else {
            axis.short()
        };
        let longer = |shorter: &Combination, value: &String| {
            let (key, mut settings) = (&axis.key, shorter.settings.clone());
            settings.push(format!("{key}={value}"));
            let (name, value) = (for_a_folder(name), for_a_folder(value));
            Combination {
                suffix: format!("{}+{name}={value}", shorter.suffix),
                settings,
            }
        };
        let longer = |shorter: &Combination| -> Vec<Combination> {
            axis.values.iter().map(|v| longer(shorter, v)).collect()
        };
        all = all.iter().flat_map(longer).collect();
    }
    tell_apart(&mut all);
    Ok(all)
}

/// Replaces characters that a folder's name cannot have by `_`, and removes them at both ends of the text.
fn for_a_folder(text: &str) -> String {
    let is_kept = |c: char| c.is_alphanumeric() || ".,-".contains(c);
    let parts = text.split(|c| !is_kept(c));
    let parts: Vec<&str> = parts.filter(|part| !part.is_empty()).collect();
    parts.join("_")
}

/// Makes suffixes short enough for the names of folders, and makes repeated suffixes unique by a number.
fn tell_apart(all: &mut [Combination]) {
    let mut known = BTreeSet::new();
    for Combination { suffix, .. } in all {
        let ends = 0..=suffix.len().min(LONGEST);
        let end = ends.rev().find(|&end| suffix.is_char_boundary(end));
        suffix.truncate(end.unwrap_or(0));
        let (whole, mut number) = (suffix.clone(), 1);
        while !known.insert(suffix.clone()) {
            number += 1;
            *suffix = format!("{whole}~{number}");
        }
    }
}
