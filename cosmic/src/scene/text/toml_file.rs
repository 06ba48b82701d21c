//! A TOML file that is not a scene but contains settings of scenes in some of its tables: the file of a sweep.

use super::read::Reader;
use super::syntax::parsed;
use crate::error::{Error, Result};
use crate::reading::in_words;
use crate::scene::Scene;
use crate::scene::base::TOP_KEYS;
use crate::scene::diagnostic::{Fault, SceneText, malformed, suggest};
use crate::scene::keys::sections;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

/// A parsed TOML file and its name. Its errors show the line, the value and what is allowed.
pub struct TomlFile<'t> {
    source: SceneText<'t>,
    text: &'t str,
    document: Spanned<DeTable<'t>>,
}

impl<'t> TomlFile<'t> {
    /// Parses the text of a file.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a text that is not TOML.
    pub fn parse(file: &'t str, text: &'t str) -> Result<Self> {
        let source = SceneText::file(file, text);
        match parsed(0, Some(file), text) {
            Ok(document) => Ok(Self {
                source,
                text,
                document,
            }),
            Err(fault) => Err(malformed(&[source], vec![fault])),
        }
    }

    /// Converts the whole file to a value of type `T`.
    ///
    /// # Errors
    /// [`Error::Malformed`] for a missing key and for a wrong value. If `T` denies unknown fields, also for an unknown
    /// key.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T> {
        toml::from_str(self.text).map_err(|error| {
            let message = error.message().replace("field `", "key `");
            let message = message.replace("type: sequence", "type: list");
            let (message, allowed) = match message.split_once(", expected ") {
                Some((found, expected)) => match found.strip_prefix("unknown key ") {
                    Some(key) => {
                        let names = expected.split('`').skip(1).step_by(2);
                        (found, suggest(key.trim_matches('`'), names))
                    }
                    None => (found, format!("expected {}", in_words(expected))),
                },
                None => (&message[..], String::new()),
            };
            self.fault(error.span().unwrap_or(0..0), message, &allowed)
        })
    }

    /// True if the file has lists of sections that no scene has.
    pub fn is_of_sweep(&self) -> bool {
        key_of_sweep(self.document.get_ref()).is_some()
    }

    /// Changes a scene by the settings in the table at `path`, such as `trials[3].settings`. Without such a table, the
    /// scene does not change. For each key in `chosen`, such as `physics.dt`, the table has a list of values, and `chosen`
    /// has the index of the value to use.
    ///
    /// # Errors
    /// The errors of [`Scene::with`].
    pub fn change(
        &self,
        scene: &Scene,
        path: &str,
        chosen: &BTreeMap<String, usize>,
    ) -> Result<Scene> {
        let Some(value) = self.value(path) else {
            return Ok(scene.clone());
        };
        match value.get_ref().as_table() {
            Some(table) => {
                let table = entries(table, "", chosen);
                Reader::changed(scene.clone(), &self.source, &table)
            }
            None => Err(self.wrong(path, "must be a section of settings, not", "")),
        }
    }

    /// Checks that every name in `names` is in `known`. `names` is the list that the file has at `path`.
    ///
    /// # Errors
    /// [`Error::Malformed`] for the first name that is unknown.
    pub fn check_names(&self, path: &str, names: &[String], known: &[String]) -> Result<()> {
        let unknown = names.iter().position(|name| !known.contains(name));
        unknown.map_or(Ok(()), |k| {
            let allowed = suggest(&names[k], known.iter().map(|name| &name[..]));
            Err(self.wrong(&format!("{path}[{k}]"), "is unknown:", &allowed))
        })
    }

    /// Makes an error about the value at a path. It shows the path, the problem, the value as it is written, and what
    /// is allowed.
    pub fn wrong(&self, path: &str, says: &str, allowed: &str) -> Error {
        let span = self.value(path).map_or(0..0, Spanned::span);
        let written = self.text.get(span.clone()).unwrap_or_default();
        self.fault(span, &format!("`{path}` {says} {written}"), allowed)
    }

    fn fault(&self, span: Range<usize>, message: &str, allowed: &str) -> Error {
        let fault = Fault {
            source: 0,
            span,
            message: message.to_owned(),
            allowed: allowed.to_owned(),
        };
        malformed(std::slice::from_ref(&self.source), vec![fault])
    }

    /// The value at a path such as `trials[3].settings`.
    fn value(&self, path: &str) -> Option<&Spanned<DeValue<'t>>> {
        let mut steps = path.split(['.', '[']);
        let first = self.document.get_ref().get(steps.next()?);
        steps.try_fold(first?, |value, step| match step.strip_suffix(']') {
            None => value.get_ref().as_table()?.get(step),
            Some(index) => value
                .get_ref()
                .as_array()?
                .get(index.parse::<usize>().ok()?),
        })
    }
}

/// The first list of sections in a table whose name a scene does not know. The file of a sweep has such lists, a scene
/// has none.
pub(super) fn key_of_sweep<'d, 't>(table: &'d DeTable<'t>) -> Option<&'d Spanned<DeString<'t>>> {
    // Asked of lists only, because most files have none.
    let is_of_scene = |key: &str| {
        let mut scene = Scene::paper();
        let mut known = sections(&mut scene).into_iter().map(|section| section.name);
        TOP_KEYS.contains(&key) || known.any(|name| name == key)
    };
    let is_table = |value: &Spanned<DeValue>| value.get_ref().is_table();
    let has_sections = |value: &DeValue| value.as_array().is_some_and(|v| v.iter().all(is_table));
    let lists = table
        .iter()
        .filter(|(key, value)| has_sections(value.get_ref()) && !is_of_scene(key.get_ref()));
    lists.map(|(key, _)| key).min_by_key(|key| key.span().start)
}

/// A copy of a table with one entry of each list whose path is in `chosen`. `prefix` is the path of the table.
fn entries<'t>(table: &DeTable<'t>, prefix: &str, chosen: &BTreeMap<String, usize>) -> DeTable<'t> {
    let entry = |(key, value): (&Spanned<DeString<'t>>, &Spanned<DeValue<'t>>)| {
        let path = format!("{prefix}{}", key.get_ref());
        let entry = match (chosen.get(&path), value.get_ref()) {
            (Some(index), list) => list.as_array()?.get(*index)?.clone(),
            (None, DeValue::Table(inner)) => {
                let inner = entries(inner, &format!("{path}."), chosen);
                Spanned::new(value.span(), DeValue::Table(inner))
            }
            (None, _) => value.clone(),
        };
        Some((key.clone(), entry))
    };
    table.iter().filter_map(entry).collect()
}
