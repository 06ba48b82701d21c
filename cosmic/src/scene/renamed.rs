//! Keys of earlier versions that another key has replaced. A scene may still state them, also in an option `--set`.
//!
//! A file of an earlier version may state both keys. The old key is read after all other keys of its section. Its meaning
//! may depend on the value that the new key has then: the value in the file, or the value in the scene that the file or
//! the option changes.

use super::read::Reader;
use crate::settings::{Filled, wrong_kind};
use toml::Spanned;
use toml::de::DeValue;

/// A key of earlier versions, and the key that replaced it. Both are written as `section.key`.
pub(super) struct RenamedKey {
    /// The old key.
    old: &'static str,
    /// The key that replaced it.
    new: &'static str,
    /// The values that the old key allows, as a phrase.
    allowed: &'static str,
    /// Translates a value of the old key.
    translate: fn(&Spanned<DeValue>, &NewKey) -> Filled<Translated>,
}

/// The key that replaced an old key, when the old key is read.
struct NewKey {
    /// The value as TOML.
    value: String,
    /// True if the text that has the old key also states this key.
    is_stated: bool,
}

/// The meaning of an old key for the key that replaced it.
enum Translated {
    /// The new key gets this value, written as TOML.
    Value(&'static str),
    /// The new key keeps its value.
    Unchanged,
    /// The two keys contradict each other.
    Contradiction,
}

impl Reader<'_, '_> {
    /// The old key with this path, if there is one.
    pub(super) fn old_key(path: &str) -> Option<&'static RenamedKey> {
        RENAMED.iter().find(|renamed| renamed.old == path)
    }

    /// Reads the value of an old key into the key that replaced it.
    pub(super) fn renamed_key(&mut self, key: &RenamedKey, value: &Spanned<DeValue>) {
        let (old, new) = (key.old, key.new);
        let now = self.scene.field(new).map(|field| field.value.toml());
        let place = self.places.get(new);
        let now = NewKey {
            value: now.unwrap_or_default(),
            is_stated: place.is_some_and(|place| place.source == self.source),
        };
        match (key.translate)(value, &now) {
            Err(misfit) => self.misfit(old, value, misfit, format!("allowed: {}", key.allowed)),
            Ok(Translated::Unchanged) => {}
            Ok(Translated::Value(text)) => {
                if let Some(field) = self.scene.field(new) {
                    let read = field.read_text(text);
                    debug_assert!(read.is_ok(), "`{new}` has no value {text}");
                }
                self.place(new.to_owned(), value);
            }
            Ok(Translated::Contradiction) => {
                let text = &self.sources[self.source].text;
                let written = text.get(value.span()).unwrap_or_default();
                let message = format!("`{old}` is {written}, but `{new}` is {}", now.value);
                let allowed = format!("`{new}` has replaced `{old}`: remove `{old}`");
                self.fault(value.span(), message, allowed);
            }
        }
    }
}

/// Every old key.
const RENAMED: [RenamedKey; 1] = [RenamedKey {
    old: "controller.two_goals",
    new: "controller.goals",
    allowed: "true or false",
    translate: two_goals,
}];

/// `two_goals` stood beside `goals`, which was "fixed" or "given". Given goals excluded `two_goals = true`.
fn two_goals(old: &Spanned<DeValue>, goals: &NewKey) -> Filled<Translated> {
    let are_two = old.get_ref().as_bool();
    let are_two = are_two.ok_or_else(|| wrong_kind(old))?;
    Ok(match (are_two, &*goals.value) {
        (true, r#""fixed""#) => Translated::Value(r#""two""#),
        (true, r#""given""#) => Translated::Contradiction,
        (false, r#""two""#) if goals.is_stated => Translated::Contradiction,
        (false, r#""two""#) => Translated::Value(r#""fixed""#),
        _ => Translated::Unchanged,
    })
}
