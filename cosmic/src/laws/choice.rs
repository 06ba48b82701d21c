//! The laws that a scene may choose from ([`Choice`]), and the laws that it has chosen ([`ContactLaw`], [`ForceLaws`]).

use std::any::Any;
use std::fmt;

use toml::Spanned;
use toml::de::DeValue;

use super::bars::{Actuator, BarForce, Damper, Rope, Stops};
use super::forces::{self, AnyForce, Bumpers, ForceLaw, LatticeForce, NodeForce};
use super::formula::{BarFormula, NodeFormula};
use super::ground::{AnyContact, Contact, Coulomb, NoGround, Sticking};
use super::law::Law;
use crate::registry::Registry;
use crate::settings::{
    Filled, Limits, SettingValue, Settings, Values, json, misfit, quoted, word, wrong_kind,
};

/// A law that scenes may choose by its name. [`contact`], [`on_bars`], [`on_nodes`] and [`on_lattice`] create it.
pub struct Choice(Kind);

enum Kind {
    Contact(Box<dyn AnyContact>),
    Force(Box<dyn AnyForce>),
}

/// Offers the contact law `C` to scenes, which choose it by `physics.contact = "its_name"`.
pub fn contact<C: Contact>() -> Choice {
    Choice(Kind::Contact(Box::new(C::default())))
}

/// Offers the law `L` for a force along bars to scenes, which choose it by `physics.forces = ["its_name"]`. The force is
/// added to the force of the bars' own springs.
pub fn on_bars<L: BarForce>() -> Choice {
    Choice(Kind::Force(forces::on_bars::<L>()))
}

/// Offers the law `L` for a force on nodes to scenes, which choose it by `physics.forces = ["its_name"]`. The force is
/// added to all other forces.
pub fn on_nodes<L: NodeForce>() -> Choice {
    Choice(Kind::Force(forces::on_nodes::<L>()))
}

/// Offers the law `L` for a force of any other kind to scenes, which choose it by `physics.forces = ["its_name"]`. The
/// force is added to all other forces.
pub fn on_lattice<L: LatticeForce>() -> Choice {
    Choice(Kind::Force(forces::on_lattice::<L>()))
}

/// The contact laws of this crate. Scenes choose them by name.
fn contacts() -> [Box<dyn AnyContact>; 3] {
    [
        Box::new(NoGround {}),
        Box::new(Sticking {}),
        Box::new(Coulomb::default()),
    ]
}

/// The force laws of this crate. Scenes choose them by name.
fn forces() -> [Box<dyn AnyForce>; 7] {
    [
        forces::on_bars::<Damper>(),
        forces::on_bars::<Stops>(),
        forces::on_bars::<Actuator>(),
        forces::on_bars::<Rope>(),
        forces::on_lattice::<Bumpers>(),
        forces::on_bars::<BarFormula>(),
        forces::on_nodes::<NodeFormula>(),
    ]
}

/// The noun for a law in messages.
pub(crate) const LAW: &str = "law";

/// The names of the laws of this crate.
pub(crate) fn names() -> Vec<&'static str> {
    let contacts = contacts().map(|contact| contact.name()).into_iter();
    contacts.chain(forces().map(|force| force.name())).collect()
}

impl Choice {
    /// The name by which a scene chooses the law.
    pub(crate) fn name(&self) -> &'static str {
        match &self.0 {
            Kind::Contact(contact) => contact.name(),
            Kind::Force(force) => force.name(),
        }
    }
}

impl Registry {
    /// All contact laws of this crate and of the registry, with their default settings.
    fn contacts(&self) -> impl Iterator<Item = Box<dyn AnyContact>> {
        let added = self.all::<Choice>(LAW).filter_map(|law| match &law.0 {
            Kind::Contact(contact) => Some(contact.boxed()),
            Kind::Force(_) => None,
        });
        contacts().into_iter().chain(added)
    }

    /// All forces of this crate and of the registry, with their default settings.
    fn forces(&self) -> impl Iterator<Item = Box<dyn AnyForce>> {
        let added = self.all::<Choice>(LAW).filter_map(|law| match &law.0 {
            Kind::Contact(_) => None,
            Kind::Force(force) => Some(force.boxed()),
        });
        forces().into_iter().chain(added)
    }

    /// The instruction for choosing a law, for messages; such as `set physics.contact = "coulomb"`. `None` for an
    /// unknown law.
    pub(crate) fn choosing(&self, law: &str) -> Option<String> {
        if self.contacts().any(|contact| contact.name() == law) {
            return Some(format!("set physics.contact = {law:?}"));
        }
        let is_force = self.forces().any(|force| force.name() == law);
        is_force.then(|| format!("set physics.forces = [{law:?}]"))
    }
}

/// A contact law and its settings: the type of `physics.contact`.
pub struct ContactLaw {
    law: Box<dyn AnyContact>,
    registry: Registry,
}

impl ContactLaw {
    fn new(law: impl Contact) -> Self {
        let (law, registry) = (Box::new(law), Registry::default());
        Self { law, registry }
    }

    /// The contact law of a world without ground.
    pub fn none() -> Self {
        Self::new(NoGround {})
    }

    /// The law of infinite friction: a node stops where it touches the ground.
    pub fn infinite() -> Self {
        Self::new(Sticking {})
    }

    /// The contact law with Coulomb friction (D5).
    pub fn coulomb() -> Self {
        Self::new(Coulomb::default())
    }

    /// The name of the law.
    pub fn name(&self) -> &'static str {
        self.law.name()
    }

    /// A sentence that describes the law.
    pub fn about(&self) -> &'static str {
        self.law.boxed().settings().about()
    }

    /// False if the world of this law has no ground.
    pub fn has_ground(&self) -> bool {
        self.law.has_ground()
    }

    pub(crate) fn law(&self) -> &dyn AnyContact {
        &*self.law
    }

    /// The settings of the law.
    pub fn settings(&mut self) -> &mut dyn Settings {
        self.law.settings()
    }

    /// The registry that the law was chosen from.
    pub(crate) fn registry(&self) -> &Registry {
        &self.registry
    }

    /// Chooses the law with this name, with its default settings. If the law is already chosen, it keeps its settings.
    /// Returns false for an unknown name.
    fn choose(&mut self, name: &str) -> bool {
        if name != self.name() {
            let found = self.registry.contacts().find(|law| law.name() == name);
            let Some(law) = found else {
                return false;
            };
            self.law = law;
        }
        true
    }
}

impl Clone for ContactLaw {
    fn clone(&self) -> Self {
        Self {
            law: self.law.boxed(),
            registry: self.registry.clone(),
        }
    }
}

impl fmt::Debug for ContactLaw {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{:?}", self.name())
    }
}

impl PartialEq for ContactLaw {
    fn eq(&self, other: &Self) -> bool {
        let values = |law: &Self| (law.name(), Values::of(law.law.boxed().settings()));
        values(self) == values(other)
    }
}

/// The middle part of the message about an unknown law. The wrong name stands before it, the known names after it.
const NO_LAW: &str = "names an unknown law:";

impl SettingValue for ContactLaw {
    fn allowed(&self, _: &Limits) -> String {
        let names = quoted(self.registry.contacts().map(|law| law.name()), " or ");
        format!("{names}; any other law needs a program that adds it")
    }

    fn json(&self) -> serde_json::Value {
        self.name().into()
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let name = word(value)?;
        match self.choose(name) {
            true => Ok(()),
            false => Err(misfit(value, NO_LAW)),
        }
    }

    fn know(&mut self, registry: &Registry) {
        self.registry = registry.clone();
    }
}

/// The chosen force laws and their settings: the type of `physics.forces`.
#[derive(Default)]
pub struct ForceLaws {
    laws: Vec<Box<dyn AnyForce>>,
    registry: Registry,
}

impl ForceLaws {
    /// The force law with this name. It has its chosen settings if it is among these laws, otherwise its default
    /// settings.
    fn law_of(&self, name: &str) -> Option<Box<dyn AnyForce>> {
        let here = self.laws().map(AnyForce::boxed);
        here.chain(self.registry.forces())
            .find(|force| force.name() == name)
    }

    /// The law of the type `L` with its settings; `None` if the scene has not chosen it.
    pub fn chosen<L: Law>(&self) -> Option<L> {
        let mut laws = self.laws().map(|law| -> &dyn Any { law });
        let chosen: &ForceLaw<L> = laws.find_map(<dyn Any>::downcast_ref)?;
        Some(chosen.law.clone())
    }

    /// Changes the settings of the law of the type `L`, if the scene has chosen it.
    pub(crate) fn change<L: Law>(&mut self, change: impl FnOnce(&mut L)) {
        let mut laws = self
            .laws
            .iter_mut()
            .map(|law| -> &mut dyn Any { &mut **law });
        if let Some(ForceLaw { law, .. }) = laws.find_map(<dyn Any>::downcast_mut) {
            change(law);
        }
    }

    /// The name and the description of each law.
    pub fn about(&self) -> Vec<(&'static str, &'static str)> {
        let about = |law: &dyn AnyForce| (law.name(), law.boxed().settings().about());
        self.laws().map(about).collect()
    }

    /// A copy of the chosen laws without the law `name`.
    #[must_use]
    pub fn without(&self, name: &str) -> Self {
        let mut others = self.clone();
        others.laws.retain(|law| law.name() != name);
        others
    }

    pub(crate) fn laws(&self) -> impl Iterator<Item = &dyn AnyForce> {
        self.laws.iter().map(|force| &**force)
    }

    /// The name and the settings of each law.
    pub fn settings(&mut self) -> impl Iterator<Item = (&'static str, &mut dyn Settings)> {
        let laws = self.laws.iter_mut();
        laws.map(|force| (force.name(), force.settings()))
    }
}

impl Clone for ForceLaws {
    fn clone(&self) -> Self {
        Self {
            laws: self.laws().map(AnyForce::boxed).collect(),
            registry: self.registry.clone(),
        }
    }
}

impl fmt::Debug for ForceLaws {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let names = self.laws().map(AnyForce::name);
        f.debug_list().entries(names).finish()
    }
}

impl PartialEq for ForceLaws {
    fn eq(&self, other: &Self) -> bool {
        let value = |law: &dyn AnyForce| (law.name(), Values::of(law.boxed().settings()));
        self.laws().map(value).eq(other.laws().map(value))
    }
}

impl SettingValue for ForceLaws {
    fn allowed(&self, _: &Limits) -> String {
        let names = quoted(self.registry.forces().map(|force| force.name()), ", ");
        format!("an array of names among {names}, each once")
    }

    fn json(&self) -> serde_json::Value {
        json(&self.laws().map(AnyForce::name).collect::<Vec<_>>())
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let entries = value.get_ref().as_array();
        let entries = entries.ok_or_else(|| wrong_kind(value))?;
        let mut laws: Vec<Box<dyn AnyForce>> = Vec::new();
        for entry in entries.iter() {
            let law = self.law_of(word(entry)?);
            let law = law.ok_or_else(|| misfit(entry, NO_LAW))?;
            if laws.iter().any(|other| other.name() == law.name()) {
                return Err(misfit(entry, "names a force twice:"));
            }
            laws.push(law);
        }
        self.laws = laws;
        Ok(())
    }

    fn know(&mut self, registry: &Registry) {
        self.registry = registry.clone();
    }
}
