//! The parts of reading a scene that need more than one key: the base and the version, missing keys, numbers that
//! follow from others, and contradictions.

use super::read::{KeyPlace, Reader, abridged};
use super::toml_file::key_of_sweep;
use crate::error::{command, in_shell};
use crate::scene::Scene;
use crate::scene::base::{Base, FORMAT, TOP_KEYS, VERSION};
use crate::scene::checks::Conflict;
use crate::scene::diagnostic::{Fault, suggest};
use crate::settings::{SettingValue, within};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The key of a scene file that names its base.
const BASE: &str = "base";

/// The advice about a scene that states its format or its version, or must hold every key.
fn of_runs() -> String {
    let shown = command("scene show SCENE");
    format!(
        "remove `format` and `version` from a scene of your own; the scene of a run holds every key, as `{shown}` prints it"
    )
}

impl Reader<'_, '_> {
    /// Begins to read a source. If the source is a whole scene, the reader starts again: from the base of that scene,
    /// or from the declared defaults if the file must be complete. Returns whether it must.
    pub(super) fn begin(&mut self, document: &DeTable) -> Result<bool, Fault> {
        if self.is_change || self.sources[self.source].file.is_none() {
            let mut stated = TOP_KEYS
                .iter()
                .filter_map(|key| document.get_key_value(*key));
            return match stated.next() {
                None => Ok(false),
                Some((key, _)) => Err(Fault {
                    source: self.source,
                    span: key.span(),
                    message: format!("`{}` cannot be changed here", key.get_ref()),
                    allowed: "it describes a whole scene file: set it at the top of that file"
                        .to_owned(),
                }),
            };
        }
        if let Some(key) = key_of_sweep(document) {
            let file = self.sources[self.source].file;
            let file = file.map_or("FILE".into(), |file| in_shell(file.as_ref()));
            return Err(Fault {
                source: self.source,
                span: key.span(),
                message: "this is the file of a sweep, not a scene".to_owned(),
                allowed: format!(
                    "run it with: {}",
                    command(format_args!("sweep run {file} --out DIR"))
                ),
            });
        }
        let base = self.base(document)?;
        let is_complete = self.is_complete(document)?;
        let scene = match (is_complete, base) {
            (false, base) => base.unwrap_or_default().scene(),
            (true, Some(base)) => Scene {
                base,
                ..Scene::paper()
            },
            (true, None) => Scene::paper(),
        };
        self.scene = scene.knowing(self.scene.registry());
        Ok(is_complete)
    }

    /// The base that the file names; `None` if it names no base.
    fn base(&self, document: &DeTable) -> Result<Option<Base>, Fault> {
        let Some(value) = document.get(BASE) else {
            return Ok(None);
        };
        let name = value.get_ref().as_str();
        if let Some(base) = name.and_then(Base::named) {
            return Ok(Some(base));
        }
        let says = match name {
            Some(_) => "names an unknown built-in scene:",
            None => "must be the name of a scene, not",
        };
        let known = suggest(name.unwrap_or_default(), Base::names().into_iter());
        Err(self.wrong(BASE, value, says, known))
    }

    /// True if no key may be missing: in the scene of a run, which states its format and its version.
    fn is_complete(&self, document: &DeTable) -> Result<bool, Fault> {
        let fault = |span, message, allowed| Fault {
            source: self.source,
            span,
            message,
            allowed,
        };
        let [format, version] = ["format", "version"].map(|key| document.get(key));
        let (format, version) = match (format, version) {
            (None, None) => return Ok(false),
            (Some(format), Some(version)) => (format, version),
            (Some(lone), None) | (None, Some(lone)) => {
                let message = "`format` and `version` cannot be used alone".to_owned();
                return Err(fault(lone.span(), message, of_runs()));
            }
        };
        let own = within(f64::from(VERSION), f64::from(VERSION));
        let is_own = 0_usize.read(version, &own).is_ok();
        if is_own && format.get_ref().as_str() == Some(FORMAT) {
            return Ok(true);
        }
        let text = &self.sources[self.source].text;
        let [format, number] = [format, version].map(|value| {
            let written = text.get(value.span());
            abridged(written.unwrap_or_default())
        });
        let message = format!(
            "the file has the format {format} version {number}, not {FORMAT:?} version {VERSION}"
        );
        Err(fault(version.span(), message, of_runs()))
    }

    /// A fault about the value of a key above the first section.
    fn wrong(&self, key: &str, value: &Spanned<DeValue>, says: &str, allowed: String) -> Fault {
        let text = &self.sources[self.source].text;
        let written = abridged(text.get(value.span()).unwrap_or_default());
        Fault {
            source: self.source,
            span: value.span(),
            message: format!("`{key}` {says} {written}"),
            allowed,
        }
    }

    /// Checks that no key is missing.
    pub(super) fn complete(&mut self) {
        let (places, mut missing) = (&self.places, Vec::new());
        self.scene.of_sections(|section, settings| {
            let paths = settings.fields().into_iter();
            let paths = paths.map(|field| format!("{section}.{}", field.key));
            let lacking = paths.filter(|path| !places.contains_key(path));
            missing.extend(lacking.map(|path| format!("`{path}`")));
        });
        if let Some(message) = are_missing(&missing) {
            self.fault(0..0, message, of_runs());
        }
    }

    /// Computes the settings that follow from the others. Records an error for every value that is out of its range.
    pub(super) fn follow(&mut self) {
        for key in self.scene.follow() {
            let place = self.places.get(&key).cloned().unwrap_or_default();
            let field = self.scene.field(&key).expect("a key of the scene");
            let (value, allowed) = (field.value.toml(), field.value.allowed(&field.limits));
            self.source = place.source;
            let message = format!(
                "`{key}` follows from the robot and its world as {value}, which is out of range"
            );
            self.fault(place.span, message, format!("set it; allowed: {allowed}"));
        }
    }

    /// Records an error for every one of these conflicts between settings. The error points at the first setting of the
    /// conflict that a source sets.
    pub(super) fn conflicts(&mut self, conflicts: impl IntoIterator<Item = Conflict>) {
        for conflict in conflicts {
            let mut keys = conflict.keys.iter();
            let place = keys.find_map(|key| self.places.get(*key));
            let KeyPlace { source, span } = place.cloned().unwrap_or_default();
            let [first, second] = conflict.keys.map(|key| {
                let is_set = self.is_change || self.places.contains_key(key);
                match is_set {
                    true => key.to_owned(),
                    false => format!("{key} (of the base {})", self.scene.base.name()),
                }
            });
            let hint = match first == second {
                true => String::new(),
                false => format!("see {first} and {second}"),
            };
            self.source = source;
            self.fault(span, conflict.says, hint);
        }
    }
}

/// The message about keys that are missing; `None` if there are none.
pub(super) fn are_missing(missing: &[String]) -> Option<String> {
    /// The largest number of missing keys that a message names.
    const NAMED: usize = 3;
    let (named, others) = missing.split_at(NAMED.min(missing.len()));
    Some(match (named, others.len()) {
        ([], _) => return None,
        ([one], _) => format!("{one} is missing"),
        (several, 0) => format!("{} are missing", several.join(", ")),
        (several, more) => format!("{} and {more} more keys are missing", several.join(", ")),
    })
}
