//! The settings that choose a policy or a loss by name.

use std::any::Any;
use std::fmt;

use toml::Spanned;
use toml::de::DeValue;

use crate::registry::{OFF, Registry};
use crate::settings::{Filled, Limits, SettingValue, misfit, quoted, word};

/// The policy or the loss that a scene chooses by its name.
#[derive(Clone)]
pub struct ItemName {
    kind: &'static str,
    built_in: &'static [&'static str],
    name: &'static str,
    registry: Registry,
}

impl ItemName {
    /// The noun for a policy in messages and in the registry.
    pub(crate) const POLICY: &'static str = "policy";
    /// The noun for a loss in messages and in the registry.
    pub(crate) const LOSS: &'static str = "loss";
    /// The names of the [network](crate::policy::Mlp), of the [open-loop clock](crate::policy::Clock), and of the policy for
    /// given goals.
    pub(crate) const POLICIES: [&'static str; 3] = ["mlp", "clock", "gaits"];

    /// The setting that chooses a policy. The default is the paper's network.
    pub(super) fn policy() -> Self {
        Self::of(Self::POLICY, &Self::POLICIES)
    }

    /// The setting that chooses a loss. The default is the loss of the scene's task.
    pub(super) fn loss() -> Self {
        Self::of(Self::LOSS, &[OFF])
    }

    fn of(kind: &'static str, built_in: &'static [&'static str]) -> Self {
        Self {
            kind,
            built_in,
            name: built_in[0],
            registry: Registry::default(),
        }
    }

    /// The chosen name, as scene files have it.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// True if the choice is that of the paper: the network, or the loss of the task.
    pub fn is_default(&self) -> bool {
        self.name == self.built_in[0]
    }

    /// The chosen policy or loss, if a program added it; `None` if it is built in.
    pub(crate) fn item<T: Any>(&self) -> Option<&T> {
        self.registry.get(self.kind, self.name)
    }

    fn known(&self) -> impl Iterator<Item = &'static str> {
        let built_in = self.built_in.iter().copied();
        built_in.chain(self.registry.names(self.kind))
    }

    /// Chooses the item with this name.
    ///
    /// # Errors
    /// A sentence if the name is unknown.
    pub(crate) fn choose(&mut self, name: &str) -> Result<(), String> {
        let found = self.known().find(|known| *known == name);
        self.name = found.ok_or_else(|| {
            let known: Vec<_> = self.known().map(|known| format!("`{known}`")).collect();
            let (kind, expected) = (self.kind, known.join(", "));
            format!("unknown {kind} `{name}`, expected one of {expected}")
        })?;
        Ok(())
    }
}

impl fmt::Debug for ItemName {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{:?}", self.name)
    }
}

impl From<ItemName> for String {
    fn from(chosen: ItemName) -> Self {
        chosen.name.to_owned()
    }
}

impl PartialEq for ItemName {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl SettingValue for ItemName {
    fn allowed(&self, _: &Limits) -> String {
        let (kind, names) = (self.kind, quoted(self.known(), " or "));
        format!("{names}; any other {kind} needs a program that adds it")
    }

    fn json(&self) -> serde_json::Value {
        match self.name {
            OFF => serde_json::Value::Null,
            name => name.into(),
        }
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let name = word(value)?;
        let says = format!("names an unknown {}:", self.kind);
        self.choose(name).map_err(|_| misfit(value, &says))
    }

    fn know(&mut self, registry: &Registry) {
        self.registry = registry.clone();
    }
}
