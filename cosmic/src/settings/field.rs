//! A setting: its value and its declaration.

use std::any::Any;

use serde::{Serialize, Serializer};
use serde_json::Value;
use toml::de::DeTable;

use super::limits::Limits;
use super::value::SettingValue;
use crate::registry::OFF;

/// The word in a scene file for a value that follows from the robot and its world.
pub(crate) const AUTO: &str = "auto";

/// A setting: its value and everything that its declaration says.
pub struct Field<'a> {
    /// The name of the key within its section.
    pub key: &'static str,
    /// The meaning of the key, in sentences.
    pub doc: &'static str,
    /// The unit; empty for a pure number, a name or a boolean.
    pub unit: &'static str,
    /// How the value follows from the robot and its world if the file says "auto", as a phrase. Empty if the key does
    /// not allow "auto".
    pub auto: &'static str,
    /// The source of the default: the paper, a decision (D1 to D11), or an experiment.
    pub source: &'static str,
    /// The condition under which the key is read, as a phrase. Empty if every scene reads the key.
    pub when: &'static str,
    /// Returns whether a scene reads the key.
    pub is_read: fn(&dyn Any) -> bool,
    /// The allowed range of the numbers in the value.
    pub limits: Limits,
    /// True if only cases have the key. In every scene it has its default.
    pub of_cases: bool,
    /// The value of the setting.
    pub value: &'a mut dyn SettingValue,
}

impl<'a> Field<'a> {
    /// A number that only cases have. Made for [`settings!`](crate::settings!).
    #[doc(hidden)]
    pub fn of_cases(
        key: &'static str,
        doc: &'static str,
        source: &'static str,
        value: &'a mut dyn SettingValue,
    ) -> Self {
        Self {
            key,
            doc,
            unit: "",
            auto: "",
            source,
            when: "",
            is_read: |_| true,
            limits: Limits::NONE,
            of_cases: true,
            value,
        }
    }
}

impl Field<'_> {
    /// The values that the key may have, as a phrase.
    pub fn allowed(&self) -> String {
        let allowed = self.value.allowed(&self.limits);
        match self.auto {
            "" => allowed,
            _ => format!("{allowed}, or {AUTO:?}"),
        }
    }

    /// Reads a value written in TOML into the setting.
    ///
    /// # Errors
    /// The middle part of the error message, which goes between the key and the value.
    pub fn read_text(self, text: &str) -> Result<(), String> {
        let text = format!("value = {text}");
        let table = DeTable::parse(&text).ok();
        let value = table
            .as_ref()
            .and_then(|table| table.get_ref().get("value"));
        let value = value.ok_or_else(|| "cannot be".to_owned())?;
        let read = self.value.read(value, &self.limits);
        read.map_err(|misfit| misfit.says)
    }
}

/// Evaluates a condition on a scene. The scene is passed as `Any`, because the module of scenes comes after this
/// module.
pub fn holds<T: 'static>(condition: impl Fn(&T) -> bool, scene: &dyn Any) -> bool {
    scene.downcast_ref().is_none_or(condition)
}

/// A section of a scene file. The macro [`settings!`](crate::settings!) declares sections.
pub trait Settings {
    /// A description of the section, in a sentence.
    fn about(&self) -> &'static str;
    /// The settings of the section in a case: those of a scene, and then those that only cases have. By default there are
    /// none.
    fn fields_of_cases(&mut self) -> Vec<Field<'_>> {
        Vec::new()
    }
    /// Fills the numbers of the section `[physics]` that a law reads too: `number` returns the value of a key, such as
    /// `physics.friction`. By default there are none.
    fn fill(&mut self, _number: &dyn Fn(&str) -> f64) {}
    /// The settings of the section in a scene, in the order in which they are written.
    fn fields(&mut self) -> Vec<Field<'_>> {
        let mut fields = self.fields_of_cases();
        fields.retain(|field| !field.of_cases);
        fields
    }
}

/// The keys of a section and their values as JSON, in the order in which they are written. Numbers that only cases have
/// are among them.
#[derive(PartialEq)]
pub struct Values(Vec<(&'static str, Value)>);

impl Values {
    /// Collects the keys and values of a section.
    pub fn of(section: &mut dyn Settings) -> Self {
        let fields = section.fields_of_cases().into_iter();
        Self(
            fields
                .map(|field| (field.key, field.value.json()))
                .collect(),
        )
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(key, value)| (key, value)))
    }
}

/// Reads a JSON value into a setting. JSON and TOML write numbers, strings, booleans and arrays of them alike. `null`
/// stands for `"off"` in TOML.
///
/// # Errors
/// A sentence that names the place of the value in its file, `place`, the value and what is allowed.
pub(crate) fn read_json(field: Field, place: &str, json: &Value) -> Result<(), String> {
    let allowed = field.value.allowed(&field.limits);
    let read = match json {
        // The error of `"off"` would mislead a user who wrote `null`.
        Value::Null => {
            let read = field.read_text(&format!("{OFF:?}"));
            read.map_err(|_| "cannot be".to_owned())
        }
        json => field.read_text(&json.to_string()),
    };
    read.map_err(|says| format!("`{place}` {says} {json}; allowed: {allowed}"))
}
