//! The keys of a scene. Finds a key by its name, and makes the tables of keys in the documentation.

use super::Scene;
use super::diagnostic::suggest;
use crate::error::{Error, Result};
use crate::registry::Registry;
use crate::settings::{AUTO, Field, Settings};
use serde::Serialize;

impl Scene {
    /// This scene with another registry. The settings of the scene may name the items of the registry.
    pub fn knowing(mut self, registry: &Registry) -> Self {
        self.of_sections(|_, settings| {
            let fields = settings.fields().into_iter();
            fields.for_each(|field| field.value.know(registry));
        });
        self
    }

    /// The registry of the scene: the laws, losses, policies and lattices that its settings may name in addition to the
    /// built-in ones.
    pub fn registry(&self) -> &Registry {
        self.physics.contact.registry()
    }

    /// Every setting with its value, in the order in which a scene is written.
    pub fn settings(&self) -> Vec<Setting> {
        let of_section = |name: &str, section: &mut dyn Settings| -> Vec<Setting> {
            let setting = |field: Field| Setting {
                key: format!("{name}.{}", field.key),
                value: field.value.toml(),
                unit: field.unit,
                auto: field.auto,
            };
            section.fields().into_iter().map(setting).collect()
        };
        self.clone().of_sections(of_section).concat()
    }

    /// The value of the setting with this key, such as `physics.dt`, as a scene file states it.
    ///
    /// # Errors
    /// [`Error::Usage`] for an unknown key. The message suggests a similar key.
    ///
    /// # Panics
    /// If a setting is not written as TOML.
    pub fn value(&self, path: &str) -> Result<serde_json::Value> {
        let mut scene = self.clone();
        if let Some(field) = scene.field(path) {
            let text = format!("value = {}", field.value.toml());
            let mut table: serde_json::Value = toml::from_str(&text).expect("a setting is TOML");
            return Ok(table["value"].take());
        }
        let known = sections(&mut scene);
        let of_section = |name: &str| known.iter().find(|section| section.name == name);
        let (section, key) = path.split_once('.').unwrap_or((path, path));
        let owner = known.iter().find(|section| section.keys.contains(&key));
        let hint = match (owner, of_section(section)) {
            (Some(owner), _) => format!("did you mean `{}.{key}`?", owner.name),
            (None, Some(own)) if path == section => {
                format!("it is a section; its keys are {}", own.keys.join(", "))
            }
            (None, Some(own)) => suggest(key, own.keys.iter().copied()),
            (None, None) => suggest(section, known.iter().map(|section| section.name)),
        };
        Err(Error::Usage(format!("unknown key `{path}`: {hint}")))
    }

    /// The sections that are fields of other sections: parts, the ground, and the laws with settings.
    fn own_sections(&mut self) -> Vec<(&'static str, &mut dyn Settings)> {
        let parts: (_, &mut dyn Settings) = ("parts", &mut self.materials.parts);
        let own = self.physics.own_sections().into_iter();
        [parts].into_iter().chain(own).collect()
    }

    /// Calls `of` with the name and the settings of every section and returns the results. The sections of parts, of the
    /// ground and of laws come last.
    pub fn of_sections<T>(
        &mut self,
        mut of: impl FnMut(&'static str, &mut dyn Settings) -> T,
    ) -> Vec<T> {
        let mut made: Vec<T> = self.sections().map(|(name, s)| of(name, s)).into();
        let own = self.own_sections().into_iter();
        made.extend(own.map(|(name, section)| of(name, section)));
        made
    }

    /// The setting with a key such as `physics.dt`, if there is one.
    pub fn field(&mut self, path: &str) -> Option<Field<'_>> {
        let field = self.field_of_cases(path);
        field.filter(|field| !field.of_cases)
    }

    /// Like [`field`](Self::field), but also finds the numbers that only cases have.
    pub(super) fn field_of_cases(&mut self, path: &str) -> Option<Field<'_>> {
        let (section, key) = path.split_once('.')?;
        let is_own = self.sections().iter().all(|(name, _)| *name != section);
        let mut sections = if is_own {
            self.own_sections()
        } else {
            self.sections().into()
        };
        let at = sections.iter().position(|(name, _)| *name == section)?;
        let (_, settings) = sections.swap_remove(at);
        let mut fields = settings.fields_of_cases().into_iter();
        fields.find(|field| field.key == key)
    }
}

/// A setting of a scene as text: its key and its value.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Setting {
    /// The key, such as `physics.dt`.
    pub key: String,
    /// The value as a scene file states it.
    pub value: String,
    /// The unit of its numbers; empty for numbers without a unit and for other values.
    #[serde(skip)]
    pub unit: &'static str,
    /// How the value follows from the robot and its world if the file says "auto", as a phrase. Empty if the key does
    /// not allow "auto".
    #[serde(skip)]
    pub auto: &'static str,
}

/// The name of a section, and the keys in this section.
pub(super) struct SectionKeys {
    pub(super) name: &'static str,
    pub(super) keys: Vec<&'static str>,
}

/// The name and the keys of every section. The sections of parts, of the ground and of laws come last.
pub(super) fn sections(scene: &mut Scene) -> Vec<SectionKeys> {
    scene.of_sections(|name, settings| SectionKeys {
        name,
        keys: settings.fields().iter().map(|field| field.key).collect(),
    })
}

/// Returns the allowed values of the key at `path`, such as `physics.dt`, as a phrase, or `None` if `number` is one of them.
///
/// # Panics
/// If no scene has the key.
pub(super) fn allowed_instead(path: &str, number: f64) -> Option<String> {
    let mut scene = Scene::paper();
    let field = scene.field(path).expect("a key of a scene");
    (!field.limits.contain(number)).then(|| field.value.allowed(&field.limits))
}

/// A description of every key of a scene file in Markdown. Each section has a table with default, unit, allowed values,
/// source of the default, and meaning.
pub fn reference() -> String {
    let sections = Scene::paper().of_sections(|name, settings| {
        let mut text = format!("### `[{name}]`\n\n{}\n\n", settings.about());
        text += "| key | default | unit | allowed | source | meaning |\n";
        text += "| --- | --- | --- | --- | --- | --- |\n";
        for field in settings.fields() {
            let (key, unit, source, doc) = (field.key, field.unit, field.source, field.doc);
            let (default, allowed) = (field.value.toml(), field.allowed());
            let auto = match field.auto {
                "" => String::new(),
                auto => format!(" With {AUTO:?}: {auto}."),
            };
            text += &format!(
                "| `{key}` | `{default}` | {unit} | {allowed} | {source} | {doc}{auto} |\n"
            );
        }
        text + "\n"
    });
    sections.concat()
}
