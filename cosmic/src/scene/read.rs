//! Reading a scene: TOML over the defaults, every value checked, every fault pointed at.

use super::diagnostic::{Fault, malformed};
use super::field::{Field, Limits, Section, Slot, cycle};
use super::table::SECTIONS;
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
        let document = match DeTable::parse(text) {
            Ok(document) => document,
            Err(error) => return Err(malformed(file, text, vec![syntax(&error)])),
        };
        let mut reader = Reader {
            text,
            scene: self.clone(),
            faults: Vec::new(),
            spans: HashMap::new(),
        };
        for (name, value) in document.get_ref() {
            reader.section(name.get_ref(), name.span(), value);
        }
        if reader.faults.is_empty() {
            reader.conflicts();
        }
        if reader.faults.is_empty() {
            Ok(reader.scene)
        } else {
            Err(malformed(file, text, reader.faults))
        }
    }
}

/// Where a scene's text sets a key, such as `physics.dt`, if it does.
fn place(text: &str, key: &str) -> Option<Range<usize>> {
    let document = DeTable::parse(text).ok()?;
    let (section, key) = key.split_once('.')?;
    let table = document.get_ref().get(section)?.get_ref().as_table()?;
    Some(table.get(key)?.span())
}

/// The error for a setting that turned out wrong after reading, shown where the text sets it;
/// `None` where it does not.
pub(super) fn pointed(
    (file, text): (&str, &str),
    key: &str,
    [message, allowed]: [&str; 2],
) -> Option<Error> {
    let fault = Fault {
        span: place(text, key)?,
        message: message.to_owned(),
        allowed: allowed.to_owned(),
    };
    Some(malformed(file, text, vec![fault]))
}

/// What the TOML parser objects to.
fn syntax(error: &toml::de::Error) -> Fault {
    let message = error.message().replace('\n', ", ");
    Fault {
        span: error.span().unwrap_or(0..0),
        message: format!("not TOML: {message}"),
        allowed: String::new(),
    }
}

struct Reader<'t> {
    text: &'t str,
    scene: Scene,
    faults: Vec<Fault>,
    /// Where the file sets `section.key`.
    spans: HashMap<String, Range<usize>>,
}

impl Reader<'_> {
    fn fault(&mut self, span: Range<usize>, message: String, allowed: String) {
        self.faults.push(Fault {
            span,
            message,
            allowed,
        });
    }

    fn section(&mut self, name: &str, span: Range<usize>, value: &Spanned<DeValue>) {
        let Some(section) = SECTIONS.iter().find(|section| section.name == name) else {
            let message = format!("unknown section `{name}`");
            return self.fault(
                span,
                message,
                suggest(name, SECTIONS.iter().map(|section| section.name)),
            );
        };
        let Some(table) = value.get_ref().as_table() else {
            let message = format!("`{name}` is {}, not a section", kind(value));
            return self.fault(
                value.span(),
                message,
                format!("write [{name}] and its keys below"),
            );
        };
        for (key, value) in table {
            match section
                .fields
                .iter()
                .find(|field| field.key == key.get_ref().as_ref())
            {
                Some(field) => self.field(section, field, value),
                None => self.unknown_key(section, key.get_ref(), key.span()),
            }
        }
    }

    fn unknown_key(&mut self, section: &Section, key: &str, span: Range<usize>) {
        let owner = SECTIONS
            .iter()
            .find(|other| other.fields.iter().any(|field| field.key == key));
        let hint = match owner {
            Some(owner) => format!("belongs to [{}]", owner.name),
            None => suggest(key, section.fields.iter().map(|field| field.key)),
        };
        self.fault(
            span,
            format!("unknown key `{key}` in [{}]", section.name),
            hint,
        );
    }

    fn field(&mut self, section: &Section, field: &Field, value: &Spanned<DeValue>) {
        let path = format!("{}.{}", section.name, field.key);
        let slot = (field.slot)(&mut self.scene);
        let allowed = format!("allowed: {}", slot.allowed(&field.limits));
        if let Err((span, misfit)) = fill(slot, &field.limits, value) {
            let written = abridged(self.text.get(span.clone()).unwrap_or_default());
            let message = match misfit {
                Misfit::Kind(kind) => format!("`{path}` is {kind}: {written}"),
                Misfit::Length(length) => format!("`{path}` has {length} entries: {written}"),
                Misfit::Range => format!("`{path}` is out of range: {written}"),
                Misfit::Word => format!("`{path}` cannot be {written}"),
            };
            self.fault(span, message, allowed);
        }
        self.spans.insert(path, value.span());
    }

    /// Points a conflict at the first of its settings that the file names.
    fn conflicts(&mut self) {
        for conflict in check::conflicts(&self.scene) {
            let span = conflict
                .keys
                .iter()
                .find_map(|key| self.spans.get(*key))
                .cloned();
            let [first, second] = conflict.keys;
            let hint = if first == second {
                String::new()
            } else {
                format!("see {first} and {second}")
            };
            self.fault(span.unwrap_or(0..0), conflict.says, hint);
        }
    }
}

/// Why a value does not go into its slot.
enum Misfit {
    Kind(&'static str),
    Length(usize),
    Range,
    Word,
}

type Filled<T> = std::result::Result<T, (Range<usize>, Misfit)>;

/// Puts a value where it belongs.
fn fill(slot: Slot, limits: &Limits, value: &Spanned<DeValue>) -> Filled<()> {
    let unknown_word = || (value.span(), Misfit::Word);
    match slot {
        Slot::Number(x) => *x = number(value, limits)?,
        Slot::Bound(x) => {
            *x = if value.get_ref().as_str() == Some("off") {
                None
            } else {
                Some(number(value, limits)?)
            }
        }
        Slot::Numbers(xs) => {
            for (entry, x) in entries(value, xs.len())?.into_iter().zip(xs) {
                *x = number(entry, limits)?;
            }
        }
        Slot::Count(n) => *n = count(value, limits)?,
        Slot::Counts(ns) => {
            for (entry, n) in entries(value, ns.len())?.into_iter().zip(ns) {
                *n = count(entry, limits)?;
            }
        }
        Slot::Flag(flag) => *flag = value.get_ref().as_bool().ok_or_else(|| wrong_kind(value))?,
        Slot::Choice(choice) => {
            let name = value.get_ref().as_str().ok_or_else(|| wrong_kind(value))?;
            if !choice.choose(name) {
                return Err(unknown_word());
            }
        }
        Slot::Cycle(passes) => {
            let letters = value.get_ref().as_str().ok_or_else(|| wrong_kind(value))?;
            let read = cycle(letters).filter(|passes| limits.contain(passes.len() as f64));
            *passes = read.ok_or_else(unknown_word)?;
        }
    }
    Ok(())
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
        .ok_or_else(|| (value.span(), Misfit::Range))
}

/// A whole number.
fn count(value: &Spanned<DeValue>, limits: &Limits) -> Filled<usize> {
    let DeValue::Integer(n) = value.get_ref() else {
        return Err(wrong_kind(value));
    };
    let n = usize::from_str_radix(n.as_str(), n.radix()).ok();
    n.filter(|n| limits.contain(*n as f64))
        .ok_or_else(|| (value.span(), Misfit::Range))
}

/// An array's entries, so many of them.
fn entries<'v, 't>(
    value: &'v Spanned<DeValue<'t>>,
    length: usize,
) -> Filled<Vec<&'v Spanned<DeValue<'t>>>> {
    let array = value
        .get_ref()
        .as_array()
        .ok_or_else(|| wrong_kind(value))?;
    if array.len() != length {
        return Err((value.span(), Misfit::Length(array.len())));
    }
    Ok(array.iter().collect())
}

fn wrong_kind(value: &Spanned<DeValue>) -> (Range<usize>, Misfit) {
    (value.span(), Misfit::Kind(kind(value)))
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
