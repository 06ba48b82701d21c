//! Reading a scene: TOML over the defaults, every value checked, every fault pointed at.

use super::diagnostic::{Fault, SceneText, malformed};
use super::field::{Field, Limits, Slot};
use super::keys::sections;
use super::pass::cycle;
use super::{Scene, check};
use crate::error::{Error, Result};
use std::collections::HashMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

impl Scene {
    /// Reads a scene from TOML. Keys left out keep their defaults.
    ///
    /// # Errors
    /// [`Error::Malformed`], naming `file`, for anything that is not TOML,
    /// an unknown key, a value of the wrong type or out of its range, and settings that contradict
    /// one another.
    pub fn parse(file: &str, text: &str) -> Result<Scene> {
        Scene::default().with(file, text)
    }

    /// The scene with the settings of a TOML text in place of its own.
    ///
    /// # Errors
    /// As [`Scene::parse`].
    pub fn with(&self, file: &str, text: &str) -> Result<Scene> {
        self.overridden(&[SceneText::file(file, text)])
    }

    /// The scene with single settings in place of its own, each a key and a TOML value such as
    /// `physics.gravity=9.81`; of several for one key the last counts. Words need no quotes:
    /// `physics.contact=coulomb`. Whether settings fit one another is checked after all of them.
    ///
    /// # Errors
    /// As [`Scene::parse`], naming `--set` and the setting in place of a file and a line.
    pub fn set(&self, settings: &[impl AsRef<str>]) -> Result<Scene> {
        self.overridden(&options(settings))
    }

    fn overridden(&self, sources: &[SceneText]) -> Result<Scene> {
        let mut reader = Reader {
            sources,
            source: 0,
            scene: self.clone(),
            faults: Vec::new(),
            places: HashMap::new(),
        };
        for source in 0..sources.len() {
            reader.source = source;
            reader.document();
        }
        if reader.faults.is_empty() && !sources.is_empty() {
            reader.conflicts();
        }
        if reader.faults.is_empty() {
            Ok(reader.scene)
        } else {
            Err(malformed(sources, reader.faults))
        }
    }
}

/// Settings of the command line as sources.
pub(super) fn options(settings: &[impl AsRef<str>]) -> Vec<SceneText<'_>> {
    let settings = settings.iter();
    settings.map(|s| SceneText::option(s.as_ref())).collect()
}

/// Where a text sets a key, such as `physics.dt`, if it does.
fn place(text: &str, key: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let (section, key) = key.split_once('.')?;
    let table = document.get_ref().get(section)?.get_ref().as_table()?;
    Some(table.get(key)?.span())
}

/// The error for a setting that turned out wrong after reading, shown where the last of the sources
/// sets it; `None` where none does.
pub(super) fn pointed(
    sources: &[SceneText],
    key: &str,
    message: &str,
    remedy: &str,
) -> Option<Error> {
    let mut places = sources.iter().enumerate().rev();
    let (source, span) =
        places.find_map(|(source, given)| Some((source, place(&given.text, key)?)))?;
    let fault = Fault {
        source,
        span,
        message: message.to_owned(),
        allowed: remedy.to_owned(),
    };
    Some(malformed(sources, vec![fault]))
}

/// Reads sources one after the other into a scene.
struct Reader<'s, 't> {
    sources: &'s [SceneText<'t>],
    /// The one that is being read.
    source: usize,
    scene: Scene,
    faults: Vec<Fault>,
    /// Where `section.key` was set last.
    places: HashMap<String, KeyPlace>,
}

/// A value's bytes in one of the sources.
#[derive(Clone, Default)]
struct KeyPlace {
    source: usize,
    span: Range<usize>,
}

impl Reader<'_, '_> {
    fn fault(&mut self, span: Range<usize>, message: String, allowed: String) {
        self.faults.push(Fault {
            source: self.source,
            span,
            message,
            allowed,
        });
    }

    fn document(&mut self) {
        let SceneText { file, text } = &self.sources[self.source];
        if file.is_none() && !text.contains('=') {
            let message = format!("`{text}` has no value");
            let allowed = "write SECTION.KEY=VALUE, as physics.gravity=9.81";
            return self.fault(0..text.len(), message, allowed.to_owned());
        }
        match DeTable::parse(text) {
            Ok(document) => {
                for (name, value) in document.get_ref() {
                    self.section(name.get_ref(), name.span(), value);
                }
            }
            Err(error) => {
                let message = format!("not TOML: {}", error.message().replace('\n', ", "));
                self.fault(error.span().unwrap_or(0..0), message, String::new());
            }
        }
    }

    fn section(&mut self, name: &str, span: Range<usize>, value: &Spanned<DeValue>) {
        let known = sections();
        if known.iter().all(|section| section.name != name) {
            let owner = known.iter().find(|section| section.keys.contains(&name));
            let path = owner.map(|owner| format!("did you mean `{}.{name}`? ", owner.name));
            let names = suggest(name, known.iter().map(|section| section.name));
            let hint = path.unwrap_or_default() + &names;
            return self.fault(span, format!("unknown section `{name}`"), hint);
        }
        let Some(table) = value.get_ref().as_table() else {
            let message = format!("`{name}` is {}, not a section", kind(value));
            let allowed = if self.sources[self.source].file.is_some() {
                format!("write [{name}] and its keys below")
            } else {
                format!("write {name}.KEY=VALUE")
            };
            return self.fault(value.span(), message, allowed);
        };
        for (key, value) in table {
            match self.scene.field(name, key.get_ref()) {
                Some(mut field) => {
                    let path = format!("{name}.{}", field.key);
                    if let Err(misfit) = fill(&mut field, value) {
                        let allowed = format!("allowed: {}", field.allowed());
                        let text = &self.sources[self.source].text;
                        let written = text.get(misfit.span.clone()).unwrap_or_default();
                        let message = format!("`{path}` {} {}", misfit.says, abridged(written));
                        self.fault(misfit.span, message, allowed);
                    }
                    let (source, span) = (self.source, value.span());
                    self.places.insert(path, KeyPlace { source, span });
                }
                None => self.unknown_key(name, key.get_ref(), key.span()),
            }
        }
    }

    fn unknown_key(&mut self, name: &str, key: &str, span: Range<usize>) {
        let known = sections();
        let owner = known.iter().find(|other| other.keys.contains(&key));
        let keys = known.iter().filter(|section| section.name == name);
        let hint = match owner {
            Some(owner) => format!("belongs to [{}]", owner.name),
            None => suggest(key, keys.flat_map(|section| &section.keys).copied()),
        };
        self.fault(span, format!("unknown key `{key}` in [{name}]"), hint);
    }

    /// Points a conflict at the first of its settings that the sources name.
    fn conflicts(&mut self) {
        for conflict in check::conflicts(&self.scene) {
            let mut keys = conflict.keys.iter();
            let place = keys.find_map(|key| self.places.get(*key));
            let KeyPlace { source, span } = place.cloned().unwrap_or_default();
            let [first, second] = conflict.keys;
            let hint = if first == second {
                String::new()
            } else {
                format!("see {first} and {second}")
            };
            self.source = source;
            self.fault(span, conflict.says, hint);
        }
    }
}

/// A value that does not go into its field: where it is, and why, to be said before the value.
struct Misfit {
    span: Range<usize>,
    says: String,
}

type Filled<T> = std::result::Result<T, Misfit>;

/// Puts a value where it belongs.
fn fill(field: &mut Field, value: &Spanned<DeValue>) -> Filled<()> {
    let limits = &field.limits;
    match &mut field.slot {
        Slot::Number(x) => **x = number(value, limits)?,
        Slot::Bound(x) => {
            let is_off = value.get_ref().as_str() == Some("off");
            **x = if is_off {
                None
            } else {
                Some(number(value, limits)?)
            }
        }
        Slot::Numbers(xs) => {
            for (entry, x) in entries(value, xs.len())?.zip(xs.iter_mut()) {
                *x = number(entry, limits)?;
            }
        }
        Slot::Count(n) => **n = count(value, limits)?,
        Slot::Counts(ns) => {
            for (entry, n) in entries(value, ns.len())?.zip(ns.iter_mut()) {
                *n = count(entry, limits)?;
            }
        }
        Slot::Flag(flag) => {
            **flag = value.get_ref().as_bool().ok_or_else(|| wrong_kind(value))?;
        }
        Slot::Choice(choice) => {
            if !choice.choose(word(value)?) {
                return Err(misfit(value, "cannot be"));
            }
        }
        Slot::Cycle(passes) => {
            let read = cycle(word(value)?).filter(|passes| limits.contain(passes.len() as f64));
            **passes = read.ok_or_else(|| misfit(value, "cannot be"))?;
        }
    }
    Ok(())
}

fn word<'v>(value: &'v Spanned<DeValue>) -> Filled<&'v str> {
    value.get_ref().as_str().ok_or_else(|| wrong_kind(value))
}

/// A number, written with or without a point. What overflows is infinite, and out of range.
fn number(value: &Spanned<DeValue>, limits: &Limits) -> Filled<f64> {
    let x = match value.get_ref() {
        DeValue::Float(x) => x.as_str().parse().ok(),
        DeValue::Integer(n) if n.radix() == 10 => n.as_str().parse().ok(),
        DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix())
            .ok()
            .map(|n| n as f64),
        _ => return Err(wrong_kind(value)),
    };
    x.filter(|x| limits.contain(*x))
        .ok_or_else(|| misfit(value, "is out of range:"))
}

/// A whole number.
fn count(value: &Spanned<DeValue>, limits: &Limits) -> Filled<usize> {
    let DeValue::Integer(n) = value.get_ref() else {
        return Err(wrong_kind(value));
    };
    let n = usize::from_str_radix(n.as_str(), n.radix()).ok();
    n.filter(|n| limits.contain(*n as f64))
        .ok_or_else(|| misfit(value, "is out of range:"))
}

/// An array's entries, `length` of them.
fn entries<'v, 't>(
    value: &'v Spanned<DeValue<'t>>,
    length: usize,
) -> Filled<impl Iterator<Item = &'v Spanned<DeValue<'t>>>> {
    let array = value.get_ref().as_array();
    let array = array.ok_or_else(|| wrong_kind(value))?;
    if array.len() != length {
        return Err(misfit(value, &format!("has {} entries:", array.len())));
    }
    Ok(array.iter())
}

fn misfit(value: &Spanned<DeValue>, says: &str) -> Misfit {
    Misfit {
        span: value.span(),
        says: says.to_owned(),
    }
}

fn wrong_kind(value: &Spanned<DeValue>) -> Misfit {
    misfit(value, &format!("is {}:", kind(value)))
}

/// What a TOML value is, with its article.
fn kind(value: &Spanned<DeValue>) -> &'static str {
    match value.get_ref() {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number with a point or exponent",
        DeValue::Boolean(_) => "a truth value",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a section",
    }
}

/// The known name nearest to a misspelt one, else all of them.
pub(super) fn suggest<'n>(wrong: &str, known: impl Iterator<Item = &'n str> + Clone) -> String {
    /// Jaro-Winkler similarity of two names that differ by a slip or two.
    const CLOSE: f64 = 0.8;
    let rate = |name: &&'n str| strsim::jaro_winkler(wrong, name);
    let best = known.clone().max_by(|a, b| rate(a).total_cmp(&rate(b)));
    match best.filter(|name| rate(name) > CLOSE) {
        Some(name) => format!("did you mean `{name}`?"),
        None => format!("known: {}", known.collect::<Vec<_>>().join(", ")),
    }
}

/// The first line of what a file says, cut where it is long.
fn abridged(written: &str) -> String {
    const LONGEST: usize = 40;
    let line = written.lines().next().unwrap_or_default();
    let short: String = line.chars().take(LONGEST).collect();
    if short.len() < written.len() {
        short + "..."
    } else {
        short
    }
}
