//! Writes a scene as complete TOML: one key per line, with its meaning and the allowed values above it.

use crate::scene::Scene;
use crate::scene::base::{FORMAT, VERSION};
use crate::settings::{AUTO, Settings, Values};
use serde::{Serialize, Serializer};

impl Scene {
    /// The whole scene as TOML with comments. [`Scene::parse`] reads it back to the same bits. A value that follows from
    /// the robot and its world is written as `"auto"`.
    pub fn to_toml(&self) -> String {
        self.written(false)
    }

    /// The scene as TOML. If `fixed` is true, all values are written as numbers, also those that follow from others.
    fn written(&self, fixed: bool) -> String {
        let write = |name: &str, settings: &mut dyn Settings| {
            let mut text = format!("# {}\n[{name}]\n", settings.about());
            for field in settings.fields() {
                // The unit and the source stand at the end of the sentence: "Time step, s (paper, table 2)."
                let doc = field.doc.trim_end_matches('.');
                let comma = if field.unit.is_empty() { "" } else { ", " };
                let (unit, source, allowed) = (field.unit, field.source, field.allowed());
                text += &format!("# {doc}{comma}{unit} ({source}). Allowed: {allowed}.\n");
                let (key, value, auto) = (field.key, field.value.toml(), field.auto);
                let is_auto = self.auto.contains(&format!("{name}.{key}"));
                text += &match (is_auto, fixed) {
                    (false, _) => format!("{key} = {value}\n"),
                    (true, false) => format!("# Here it is {value}: {auto}.\n{key} = {AUTO:?}\n"),
                    (true, true) => format!("# Follows from the scene: {auto}.\n{key} = {value}\n"),
                };
            }
            text
        };
        let base = self.base.name();
        let sections = self.clone().of_sections(write).join("\n");
        format!(
            "# The scene that supplies missing keys; none is missing here.\nbase = {base:?}\n\n{sections}"
        )
    }
}

impl Scene {
    /// The scene for the folder of a run: the text of [`to_toml`](Scene::to_toml) with format and version. In such a
    /// scene no key may be missing, and the values that follow from others are numbers, so that they stay as they are.
    pub fn to_run_toml(&self) -> String {
        let text = self.written(true);
        format!(
            "# The scene of a run: it must hold every key.\n\
             format = {FORMAT:?}\nversion = {VERSION}\n{text}"
        )
    }
}

/// Serializes a scene as its sections, each with its keys and values, as a [case](crate::case) has it. The order is that of
/// the TOML text.
impl Serialize for Scene {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let of = |name: &'static str, section: &mut dyn Settings| (name, Values::of(section));
        serializer.collect_map(self.clone().of_sections(of))
    }
}
