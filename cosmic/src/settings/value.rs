//! The types of settings. A type decides which values are allowed, and how values are read and written.

use super::limits::Limits;
use crate::geometry::Vector;
use crate::registry::{OFF, Registry};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::fmt::Debug;
use std::ops::Range;
use toml::Spanned;
use toml::de::DeValue;

/// A type that a setting can have.
pub trait SettingValue: Debug {
    /// The values that a file may state, as a phrase.
    fn allowed(&self, limits: &Limits) -> String;
    /// The value as TOML. Rust writes numbers, booleans and arrays of them as TOML does, with the fewest digits that
    /// read back to the same bits.
    fn toml(&self) -> String {
        format!("{self:?}")
    }
    /// The value as JSON.
    fn json(&self) -> serde_json::Value;
    /// Replaces this value by a value from a file.
    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()>;
    /// True if the value is within the limits.
    fn fits(&self, _limits: &Limits) -> bool {
        true
    }
    /// Gives the registry to this setting, if it chooses an item by its name.
    fn know(&mut self, _registry: &Registry) {}
}

/// The reason why a value is refused. It becomes part of a message such as "`physics.dt` is a string: "fast"".
pub struct Misfit {
    /// The place of the value: its bytes in the text.
    pub span: Range<usize>,
    /// The middle part of the message, which goes between key and value, such as "is a string:".
    pub says: String,
}

/// The result of reading a value.
pub type Filled<T> = Result<T, Misfit>;

/// A refusal of a value. `says` is the middle part of the message, between key and value.
pub fn misfit(value: &Spanned<DeValue>, says: &str) -> Misfit {
    Misfit {
        span: value.span(),
        says: says.to_owned(),
    }
}

fn out_of_range(value: &Spanned<DeValue>) -> Misfit {
    misfit(value, "is out of range:")
}

/// A refusal of a value of the wrong type.
pub(crate) fn wrong_kind(value: &Spanned<DeValue>) -> Misfit {
    misfit(value, &format!("is {}:", kind(value)))
}

/// The type of a TOML value as a phrase, such as "a string".
pub fn kind(value: &Spanned<DeValue>) -> &'static str {
    match value.get_ref() {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a number with a point or exponent",
        DeValue::Boolean(_) => "a boolean",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a section",
    }
}

impl SettingValue for f64 {
    fn allowed(&self, limits: &Limits) -> String {
        format!("a {} {limits}", Self::NOUN)
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    /// Reads a number, which may be written without a decimal point. A number that overflows is infinite and therefore
    /// out of range.
    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        let x = match value.get_ref() {
            DeValue::Float(x) => x.as_str().parse().ok(),
            DeValue::Integer(n) if n.radix() == 10 => n.as_str().parse().ok(),
            DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix())
                .ok()
                .map(|n| n as f64),
            _ => return Err(wrong_kind(value)),
        };
        let x = x.filter(|x: &f64| x.fits(limits));
        *self = x.ok_or_else(|| out_of_range(value))?;
        Ok(())
    }

    fn fits(&self, limits: &Limits) -> bool {
        limits.contain(*self)
    }
}

impl SettingValue for usize {
    fn allowed(&self, limits: &Limits) -> String {
        format!("a {} {limits}", Self::NOUN)
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        let DeValue::Integer(n) = value.get_ref() else {
            return Err(wrong_kind(value));
        };
        let n = usize::from_str_radix(n.as_str(), n.radix()).ok();
        let n = n.filter(|n| n.fits(limits));
        *self = n.ok_or_else(|| out_of_range(value))?;
        Ok(())
    }

    fn fits(&self, limits: &Limits) -> bool {
        limits.contain(*self as f64)
    }
}

impl SettingValue for Vector<f64> {
    fn allowed(&self, limits: &Limits) -> String {
        format!("2 numbers, [along, above], or 3, [along, across, above], each {limits}")
    }

    fn toml(&self) -> String {
        self.shown()
    }

    fn json(&self) -> serde_json::Value {
        json(&self.dimension().list(*self))
    }

    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        if value
            .get_ref()
            .as_array()
            .is_some_and(|list| list.len() == 3)
        {
            let mut all = self.array();
            all.read(value, limits)?;
            *self = all.into();
            return Ok(());
        }
        let mut in_plane = self.in_plane();
        in_plane.read(value, limits)?;
        *self = in_plane.into();
        Ok(())
    }

    fn fits(&self, limits: &Limits) -> bool {
        self.array().iter().all(|x| x.fits(limits))
    }
}

/// A number type that the entries of an array setting may have.
pub trait ArrayNumber: SettingValue {
    /// The noun for a number of this type.
    const NOUN: &'static str;
}

impl ArrayNumber for f64 {
    const NOUN: &'static str = "number";
}

impl ArrayNumber for usize {
    const NOUN: &'static str = "whole number";
}

impl<T: ArrayNumber, const N: usize> SettingValue for [T; N] {
    fn allowed(&self, limits: &Limits) -> String {
        format!("{N} {}s, each {limits}", T::NOUN)
    }

    fn json(&self) -> serde_json::Value {
        self.iter().map(T::json).collect()
    }

    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        let entries = value.get_ref().as_array();
        let entries = entries.ok_or_else(|| wrong_kind(value))?;
        if entries.len() != N {
            let noun = if entries.len() == 1 {
                "entry"
            } else {
                "entries"
            };
            return Err(misfit(value, &format!("has {} {noun}:", entries.len())));
        }
        let mut pairs = self.iter_mut().zip(entries.iter());
        pairs.try_for_each(|(x, entry)| x.read(entry, limits))
    }

    fn fits(&self, limits: &Limits) -> bool {
        self.iter().all(|x| x.fits(limits))
    }
}

/// A bound that can be switched off: `None` is "off".
impl SettingValue for Option<f64> {
    fn allowed(&self, limits: &Limits) -> String {
        format!("a number {limits}, or {OFF:?}")
    }

    fn toml(&self) -> String {
        self.map_or(format!("{OFF:?}"), |x| x.toml())
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, limits: &Limits) -> Filled<()> {
        *self = None;
        if value.get_ref().as_str() == Some(OFF) {
            return Ok(());
        }
        self.insert(0.0).read(value, limits)
    }

    fn fits(&self, limits: &Limits) -> bool {
        self.is_none_or(|x| x.fits(limits))
    }
}

impl SettingValue for bool {
    fn allowed(&self, _: &Limits) -> String {
        "true or false".to_owned()
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let read = value.get_ref().as_bool();
        *self = read.ok_or_else(|| wrong_kind(value))?;
        Ok(())
    }
}

/// An enum whose members have names in scene files.
pub trait Named: Copy + Debug + PartialEq + 'static {
    /// Every member of the enum, as a pair of its name and itself.
    const ALL: &'static [(&'static str, Self)];

    /// The name of this member.
    fn name(self) -> &'static str {
        let entry = Self::ALL.iter().find(|(_, member)| *member == self);
        entry.map_or("", |(name, _)| name)
    }
}

/// Deserializes the name of an enum's member. Made for [`settings!`](crate::settings!).
///
/// # Errors
/// The errors of the deserializer, and an error for a string that is not one of the names.
#[doc(hidden)]
pub fn member<'de, T: Named, D: Deserializer<'de>>(
    deserializer: D,
    names: &'static [&'static str],
) -> Result<T, D::Error> {
    let word = String::deserialize(deserializer)?;
    let entry = T::ALL.iter().find(|(name, _)| *name == word);
    let member = entry.map(|(_, member)| *member);
    member.ok_or_else(|| D::Error::unknown_variant(&word, names))
}

impl<T: Named> SettingValue for T {
    fn allowed(&self, _: &Limits) -> String {
        quoted(T::ALL.iter().map(|(name, _)| *name), " or ")
    }

    fn toml(&self) -> String {
        format!("{:?}", self.name())
    }

    fn json(&self) -> serde_json::Value {
        self.name().into()
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let word = word(value)?;
        let entry = T::ALL.iter().find(|(name, _)| *name == word);
        *self = entry.ok_or_else(|| misfit(value, "cannot be"))?.1;
        Ok(())
    }
}

/// Puts each name in quotes and joins the names by `between`.
pub(crate) fn quoted<'n>(names: impl Iterator<Item = &'n str>, between: &str) -> String {
    let quoted: Vec<String> = names.map(|name| format!("{name:?}")).collect();
    quoted.join(between)
}

/// The string in a TOML value.
///
/// # Errors
/// A [`Misfit`] for a value that is not a string.
pub fn word<'v>(value: &'v Spanned<DeValue>) -> Filled<&'v str> {
    value.get_ref().as_str().ok_or_else(|| wrong_kind(value))
}

/// Converts the value of a setting to JSON. This always works, because settings are numbers, names and lists of them.
pub fn json(value: &(impl serde::Serialize + ?Sized)) -> serde_json::Value {
    serde_json::to_value(value).unwrap_or_default()
}
