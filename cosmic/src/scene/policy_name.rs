//! The key of a scene that chooses a policy.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use toml::Spanned;
use toml::de::DeValue;

use crate::registry::Registry;
use crate::settings::{Filled, Limits, SettingValue, json, misfit, word};

/// The name of a policy: that of a built-in one, or of one that this process was
/// [given](crate::policy::add).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PolicyName(&'static str);

/// The names of all policies given.
static GIVEN: Registry<()> = Registry::new();

impl PolicyName {
    /// The [network](crate::policy::Mlp).
    pub(crate) const MLP: &'static str = "mlp";
    /// The [open-loop clock](crate::policy::Clock).
    pub(crate) const CLOCK: &'static str = "clock";

    /// Makes a name known to the scenes that are read from now on.
    ///
    /// # Panics
    /// If it is known already.
    pub(crate) fn add(name: &'static str) {
        assert!(
            Self::named(name).is_none(),
            "there is a policy {name:?} already"
        );
        GIVEN.add("policy", name, ());
    }

    /// The name as scenes have it.
    pub fn name(self) -> &'static str {
        self.0
    }

    fn known() -> impl Iterator<Item = &'static str> {
        let given = GIVEN.all().into_iter().map(|(name, ())| name);
        [Self::MLP, Self::CLOCK].into_iter().chain(given)
    }

    /// The policy of that name; `None` if this program has none.
    pub fn named(name: &str) -> Option<Self> {
        Self::known().find(|known| *known == name).map(Self)
    }
}

impl Default for PolicyName {
    fn default() -> Self {
        Self(Self::MLP)
    }
}

impl<'de> Deserialize<'de> for PolicyName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        Self::named(&name).ok_or_else(|| {
            let known: Vec<_> = Self::known().map(|known| format!("`{known}`")).collect();
            let expected = known.join(", ");
            D::Error::custom(format!(
                "unknown policy `{name}`, expected one of {expected}"
            ))
        })
    }
}

impl SettingValue for PolicyName {
    fn allowed(&self, _: &Limits) -> String {
        let names: Vec<String> = Self::known().map(|name| format!("{name:?}")).collect();
        let names = names.join(" or ");
        format!("{names}; another policy needs the program that brings it")
    }

    fn toml(&self) -> String {
        format!("{:?}", self.0)
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let name = word(value)?;
        *self = Self::named(name).ok_or_else(|| misfit(value, "names an unknown policy:"))?;
        Ok(())
    }
}
