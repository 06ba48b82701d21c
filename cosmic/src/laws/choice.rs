//! The laws that a scene may choose, and its choice.

use std::fmt;
use std::sync::Arc;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::Spanned;
use toml::de::DeValue;

use super::bar::{BarForce, OnBars};
use super::contact::{AnyContact, Contact};
use super::coulomb::Coulomb;
use super::damper::Damper;
use super::force::AnyForce;
use super::law_file::{LawFile, law_json};
use super::no_ground::NoGround;
use super::node::{NodeForce, OnNodes};
use super::sticking::Sticking;
use super::stops::Stops;
use crate::registry::Registry;
use crate::settings::{
    Filled, Limits, Misfit, SettingValue, Settings, misfit, unknown, word, wrong_kind,
};

/// A law that scenes may choose: made by [`contact`], [`on_bars`] or [`on_nodes`].
pub struct Choice(Kind);

enum Kind {
    Contact(Box<dyn AnyContact>),
    Force(Box<dyn AnyForce>),
}

/// A contact law, chosen by `physics.contact = "its_name"`.
pub fn contact<C: Contact>() -> Choice {
    Choice(Kind::Contact(Box::new(C::default())))
}

/// A force along bars, chosen by `physics.forces = ["its_name"]`. It is added to the bars' own springs.
pub fn on_bars<L: BarForce>() -> Choice {
    Choice(Kind::Force(Box::new(OnBars(L::default()))))
}

/// A force on nodes, chosen by `physics.forces = ["its_name"]`. It is added to all other forces.
pub fn on_nodes<L: NodeForce>() -> Choice {
    Choice(Kind::Force(Box::new(OnNodes::new(L::default()))))
}

/// The laws of this crate that scenes choose by name.
fn built_in() -> [Choice; 5] {
    [
        contact::<NoGround>(),
        contact::<Sticking>(),
        contact::<Coulomb>(),
        on_bars::<Damper>(),
        on_bars::<Stops>(),
    ]
}

/// Those that were added to them.
static ADDED: Registry<Arc<Choice>> = Registry::new();

/// The sections of a scene that are no law's.
pub(crate) const SECTIONS: [&str; 19] = [
    "lattice",
    "physics",
    "materials",
    "projection",
    "controller",
    "start",
    "design",
    "volume",
    "schedule",
    "binarisation",
    "mma",
    "adam",
    "gradient",
    "loss",
    "selection",
    "objective",
    "robust",
    "search",
    "ground",
];

/// The keys of a scene file above its first section.
pub(crate) const TOP_KEYS: [&str; 3] = ["format", "version", "base"];

/// Makes a law known to all scenes that this process reads from now on.
///
/// # Panics
/// If its name is no word of lower case letters, digits and underscores, or names a law or a section
/// of a scene already.
pub fn add(choice: Choice) {
    let name = choice.name();
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    assert!(
        name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(is_word),
        "a law is named by lower case letters, digits and underscores, not {name:?}"
    );
    let is_built_in = built_in().iter().any(|law| law.name() == name);
    assert!(!is_built_in, "there is a law {name:?} already");
    assert!(
        !SECTIONS.contains(&name) && !TOP_KEYS.contains(&name),
        "a law cannot be named {name:?}: scenes already have a section or key of that name"
    );
    ADDED.add("law", name, Arc::new(choice));
}

impl Choice {
    fn name(&self) -> &'static str {
        match &self.0 {
            Kind::Contact(contact) => contact.name(),
            Kind::Force(force) => force.name(),
        }
    }
}

/// The key of a scene that chooses a law, as a remedy; `None` if this program has no such law.
pub(crate) fn choosing(name: &str) -> Option<String> {
    if contacts().iter().any(|contact| contact.name() == name) {
        return Some(format!("set physics.contact = {name:?}"));
    }
    let is_force = forces().iter().any(|force| force.name() == name);
    is_force.then(|| format!("set physics.forces = [{name:?}]"))
}

/// The results of a function for every law that scenes may choose; those that are `None` are left out.
fn every<T>(of: fn(&Choice) -> Option<T>) -> Vec<T> {
    let added = ADDED.all();
    let added = added.iter().map(|(_, choice)| &**choice);
    built_in().iter().chain(added).filter_map(of).collect()
}

fn contacts() -> Vec<Box<dyn AnyContact>> {
    every(|choice| match &choice.0 {
        Kind::Contact(contact) => Some(contact.boxed()),
        Kind::Force(_) => None,
    })
}

fn forces() -> Vec<Box<dyn AnyForce>> {
    every(|choice| match &choice.0 {
        Kind::Contact(_) => None,
        Kind::Force(force) => Some(force.boxed()),
    })
}

/// The names of the forces of this crate that scenes choose by name.
#[cfg(test)]
pub(crate) fn force_names() -> impl Iterator<Item = &'static str> {
    let laws = built_in().into_iter();
    laws.filter_map(|law| matches!(law.0, Kind::Force(_)).then(|| law.name()))
}

/// A contact law and its settings: the type of `physics.contact`.
pub struct ContactLaw(Box<dyn AnyContact>);

impl ContactLaw {
    /// The law of that name, with its default settings; `None` if this program has none.
    pub fn named(name: &str) -> Option<Self> {
        let mut known = contacts().into_iter();
        known.find(|contact| contact.name() == name).map(Self)
    }

    /// There is no ground.
    pub fn none() -> Self {
        Self(Box::new(NoGround {}))
    }

    /// A node stops where it touches the ground.
    pub fn infinite() -> Self {
        Self(Box::new(Sticking {}))
    }

    /// Coulomb friction (D5).
    pub fn coulomb() -> Self {
        Self(Box::new(Coulomb::default()))
    }

    /// The name.
    pub fn name(&self) -> &'static str {
        self.0.name()
    }

    /// What the law says of itself, in a sentence.
    pub fn about(&self) -> &'static str {
        self.0.boxed().settings().about()
    }

    /// False if there is no ground at all.
    pub fn has_ground(&self) -> bool {
        self.0.has_ground()
    }

    pub(crate) fn law(&self) -> &dyn AnyContact {
        &*self.0
    }

    pub(crate) fn settings(&mut self) -> &mut dyn Settings {
        self.0.settings()
    }
}

impl Clone for ContactLaw {
    fn clone(&self) -> Self {
        Self(self.0.boxed())
    }
}

impl fmt::Debug for ContactLaw {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{:?}", self.name())
    }
}

impl PartialEq for ContactLaw {
    fn eq(&self, other: &Self) -> bool {
        self.json() == other.json()
    }
}

impl<'de> Deserialize<'de> for ContactLaw {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let file = LawFile::deserialize(deserializer)?;
        let Some(mut law) = Self::named(&file.name) else {
            let known = contacts();
            let known: Vec<_> = known.iter().map(|c| format!("`{}`", c.name())).collect();
            let (name, expected) = (file.name, known.join(", "));
            let says = format!("unknown variant `{name}`, expected one of {expected}");
            return Err(D::Error::custom(says));
        };
        file.fill(law.settings())?;
        Ok(law)
    }
}

impl Serialize for ContactLaw {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.json().serialize(serializer)
    }
}

/// The middle of a message about an unknown law.
const NO_LAW: &str = "names an unknown law:";

/// The names of some laws in quotes, with a word between them.
fn names<'n>(names: impl Iterator<Item = &'n str>, between: &str) -> String {
    let quoted: Vec<String> = names.map(|name| format!("{name:?}")).collect();
    quoted.join(between)
}

impl SettingValue for ContactLaw {
    fn allowed(&self, _: &Limits) -> String {
        let names = names(contacts().iter().map(|contact| contact.name()), " or ");
        format!("{names}; another law needs the program that brings it")
    }

    fn json(&self) -> serde_json::Value {
        law_json(self.name(), self.0.boxed().settings())
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let name = word(value)?;
        // A law that is named again keeps its settings.
        if name != self.name() {
            *self = Self::named(name).ok_or_else(|| unknown(value, name, NO_LAW))?;
        }
        Ok(())
    }
}

/// Force laws and their settings: the type of `physics.forces`.
#[derive(Default)]
pub struct ForceLaws(Vec<Box<dyn AnyForce>>);

impl ForceLaws {
    /// The laws of these names, with their default settings; `None` if this program lacks one.
    pub fn named(names: &[impl AsRef<str>]) -> Option<Self> {
        let mut laws = Self::default();
        let named = names.iter().map(|name| laws.law_of(name.as_ref()));
        laws.0 = named.collect::<Option<_>>()?;
        Some(laws)
    }

    /// The law of a name: with the settings that it has here, else with its defaults.
    fn law_of(&self, name: &str) -> Option<Box<dyn AnyForce>> {
        let here = self.0.iter().map(|force| force.boxed());
        here.chain(forces()).find(|force| force.name() == name)
    }

    /// The law along bars of that type with its settings here, if it is among these.
    pub fn along_bars<L: BarForce>(&self) -> Option<L> {
        let here = self.laws().find(|law| law.name() == L::NAME)?;
        let file = law_json(L::NAME, here.boxed().settings());
        let file: LawFile = serde_json::from_value(file).ok()?;
        let mut law = L::default();
        file.fill::<serde_json::Error>(&mut law).ok()?;
        Some(law)
    }

    /// The name of each, and what it says of itself in a sentence.
    pub fn about(&self) -> Vec<(&'static str, &'static str)> {
        let about = |law: &dyn AnyForce| (law.name(), law.boxed().settings().about());
        self.laws().map(about).collect()
    }

    /// All but the law of a name.
    #[must_use]
    pub fn without(&self, name: &str) -> Self {
        let others = self.laws().filter(|law| law.name() != name);
        Self(others.map(AnyForce::boxed).collect())
    }

    pub(crate) fn laws(&self) -> impl Iterator<Item = &dyn AnyForce> {
        self.0.iter().map(|force| &**force)
    }

    pub(crate) fn settings(&mut self) -> impl Iterator<Item = (&'static str, &mut dyn Settings)> {
        self.0
            .iter_mut()
            .map(|force| (force.name(), force.settings()))
    }
}

impl Clone for ForceLaws {
    fn clone(&self) -> Self {
        Self(self.0.iter().map(|force| force.boxed()).collect())
    }
}

impl fmt::Debug for ForceLaws {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list()
            .entries(self.laws().map(AnyForce::name))
            .finish()
    }
}

impl PartialEq for ForceLaws {
    fn eq(&self, other: &Self) -> bool {
        self.json() == other.json()
    }
}

impl<'de> Deserialize<'de> for ForceLaws {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut laws = Self::default();
        for file in Vec::<LawFile>::deserialize(deserializer)? {
            let name = &file.name;
            if laws.laws().any(|law| law.name() == name) {
                let twice = format!("the force `{name}` occurs twice; name it once");
                return Err(D::Error::custom(twice));
            }
            let law = laws.law_of(name);
            let unknown = || format!("unknown force `{name}`");
            let mut law = law.ok_or_else(|| D::Error::custom(unknown()))?;
            file.fill(law.settings())?;
            laws.0.push(law);
        }
        Ok(laws)
    }
}

impl Serialize for ForceLaws {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.json().serialize(serializer)
    }
}

impl SettingValue for ForceLaws {
    fn allowed(&self, _: &Limits) -> String {
        let known = forces();
        if known.is_empty() {
            return "[]; a force needs the program that brings it".to_owned();
        }
        let names = names(known.iter().map(|force| force.name()), ", ");
        format!("an array of names among {names}, each once")
    }

    fn json(&self) -> serde_json::Value {
        let json = |law: &dyn AnyForce| law_json(law.name(), law.boxed().settings());
        self.laws().map(json).collect()
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let entries = value
            .get_ref()
            .as_array()
            .ok_or_else(|| wrong_kind(value))?;
        let mut laws: Vec<Box<dyn AnyForce>> = Vec::new();
        let mut lacking: Option<Misfit> = None;
        for entry in entries.iter() {
            let name = word(entry)?;
            match (self.law_of(name), &mut lacking) {
                (Some(law), _) => {
                    if laws.iter().any(|other| other.name() == law.name()) {
                        return Err(misfit(entry, "must name each force once, but has twice:"));
                    }
                    laws.push(law);
                }
                (None, Some(lacking)) => lacking.unknown.push(name.to_owned()),
                (None, none) => *none = Some(unknown(entry, name, NO_LAW)),
            }
        }
        self.0 = laws;
        lacking.map_or(Ok(()), Err)
    }
}
