//! A setting in place, with what its declaration says of it.

use super::limits::Limits;
use super::value::SettingValue;

/// A setting in place, with all that its declaration says of it.
pub(super) struct Field<'a> {
    pub(super) key: &'static str,
    /// The meaning of the key, in sentences.
    pub(super) doc: &'static str,
    /// The unit; empty for a pure number, a name or a truth value.
    pub(super) unit: &'static str,
    /// Where the default comes from: the paper, a decision (D1 to D11), an experiment.
    pub(super) source: &'static str,
    pub(super) limits: Limits,
    pub(super) value: &'a mut dyn SettingValue,
}

impl Field<'_> {
    /// The values that the key may have, as a phrase.
    pub(super) fn allowed(&self) -> String {
        self.value.allowed(&self.limits)
    }
}

/// A section of a scene file; [`settings`](super::settings) declares it.
pub(super) trait Settings {
    /// The subject of the section, in a sentence.
    fn about(&self) -> &'static str;
    /// Its settings, in the order in which they are written.
    fn fields(&mut self) -> Vec<Field<'_>>;
}
