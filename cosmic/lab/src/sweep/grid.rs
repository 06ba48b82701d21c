//! The grid of a sweep: every combination of the values of some settings.

use cosmic::error::{Error, Result};
use cosmic::record::MOST_RUNS;
use cosmic::scene::TomlFile;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A key of a scene and the values that it takes in a sweep. With several values it is an axis of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    key: String,
    /// The values as TOML text, in the form that `--set` accepts.
    values: Vec<String>,
}

/// One point of the grid: a value for every key.
#[derive(Clone, Debug, PartialEq)]
pub struct Combination {
    /// The suffix for the scene's name, such as `+friction=0.6+gravity=9.81`. It names the keys that have several values.
    pub suffix: String,
    /// The settings of this point of the grid, such as `physics.friction=0.6`: one for each axis.
    pub settings: Vec<String>,
    /// For each key, the index of its value.
    pub chosen: BTreeMap<String, usize>,
}

/// The greatest length of a suffix, in bytes. The name of a run's folder consists of the scene's name, the suffix and
/// the seed, and may have at most 255 bytes.
const LONGEST: usize = 160;

impl Axis {
    /// Reads `KEY=V,V…`. A comma within brackets, braces or quotes does not separate.
    ///
    /// # Errors
    /// [`Error::Usage`] for a text of another form, an empty value, or a repeated value.
    pub fn parse(text: &str) -> Result<Self> {
        let Some((key, values)) = text.split_once('=') else {
            return Err(malformed(text, "`=` is missing"));
        };
        Self::new(key.trim(), separated(values)).map_err(|says| malformed(text, says))
    }

    /// The axes of the table at `path` in the file of a sweep: a list of values for every key. The keys of inner tables are
    /// joined by dots.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a value that is not a list, an empty list, and a repeated value.
    pub(super) fn of_table(
        file: &TomlFile,
        path: &str,
        table: &serde_json::Map<String, Value>,
    ) -> Result<Vec<Self>> {
        let mut axes = Vec::new();
        for (key, value) in table {
            let path = &format!("{path}.{key}");
            match value {
                Value::Object(inner) => axes.extend(Self::of_table(file, path, inner)?),
                // A number, a boolean, a string and a list are written alike in JSON and TOML.
                Value::Array(values) => {
                    let key = path.split_once('.').map_or(&path[..], |(_, key)| key);
                    let axis = Self::new(key, values.iter().map(Value::to_string).collect());
                    axes.push(axis.map_err(|says| file.wrong(path, "has a wrong list:", says))?);
                }
                _ => {
                    return Err(file.wrong(
                        path,
                        "must be a list of values, not",
                        "for example [1, 2]",
                    ));
                }
            }
        }
        Ok(axes)
    }

    fn new(key: &str, values: Vec<String>) -> std::result::Result<Self, &'static str> {
        if key.is_empty() {
            return Err("the key is missing");
        }
        if values.is_empty() || values.iter().any(String::is_empty) {
            return Err("a value is missing");
        }
        if values.iter().collect::<BTreeSet<_>>().len() < values.len() {
            return Err("a value is repeated");
        }
        let key = key.to_owned();
        Ok(Self { key, values })
    }

    /// The part of the key after the last dot, such as `friction` for `physics.friction`.
    fn short(&self) -> &str {
        self.key.rsplit('.').next().unwrap_or(&self.key)
    }

    /// True if the key has several values.
    pub(super) fn is_swept(&self) -> bool {
        self.values.len() > 1
    }

    /// The key, such as `physics.friction`.
    pub(super) fn key(&self) -> &str {
        &self.key
    }
}

fn malformed(setting: &str, says: &str) -> Error {
    Error::Usage(format!(
        "--set {setting}: {says}; expected a key and its values, as in --set physics.friction=0.6,1"
    ))
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
/// [`Error::Usage`] for two axes with the same key, and for more combinations than a sweep may have runs.
pub fn combinations(axes: &[Axis]) -> Result<Vec<Combination>> {
    for (k, axis) in axes.iter().enumerate() {
        if axes[..k].iter().any(|other| other.key == axis.key) {
            return Err(Error::Usage(format!(
                "`{}` is set twice; give all of its values in one --set or in [grid]",
                axis.key
            )));
        }
    }
    let counts = axes.iter().map(|axis| axis.values.len());
    let count = counts.fold(1_usize, usize::saturating_mul);
    if count > MOST_RUNS {
        return Err(Error::Usage(format!(
            "the grid has {count} combinations, but a sweep may have at most {MOST_RUNS} runs; give fewer values"
        )));
    }
    let mut all = vec![Combination {
        suffix: String::new(),
        settings: Vec::new(),
        chosen: BTreeMap::new(),
    }];
    for axis in axes {
        let is_other = |other: &Axis| other.key != axis.key && other.short() == axis.short();
        let is_ambiguous = axes.iter().any(is_other);
        let name = for_a_folder(if is_ambiguous {
            &axis.key
        } else {
            axis.short()
        });
        let longer = |shorter: &Combination, (index, value): (usize, &String)| {
            let mut longer = shorter.clone();
            longer.settings.push(format!("{}={value}", axis.key));
            longer.chosen.insert(axis.key.clone(), index);
            if axis.is_swept() {
                longer.suffix += &format!("+{name}={}", for_a_folder(value));
            }
            longer
        };
        let longer = |shorter: &Combination| -> Vec<Combination> {
            let values = axis.values.iter().enumerate();
            values.map(|value| longer(shorter, value)).collect()
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
