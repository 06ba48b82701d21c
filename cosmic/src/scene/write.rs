//! A scene as TOML: complete, one key a line, each with what it means and what it may be.

use super::Scene;
use super::table::SECTIONS;
use crate::error::Result;
use std::collections::HashMap;
use std::fmt::Write;

impl Scene {
    /// Refuses settings that no scene file may have. Those of a scene that was read are never
    /// refused, those of one whose fields were set may be.
    ///
    /// # Errors
    /// [`Error::Malformed`](crate::error::Error::Malformed), with places in the scene's
    /// [text](Scene::to_toml).
    pub fn check(&self) -> Result<()> {
        Self::parse("scene", &self.to_toml()).map(drop)
    }

    /// The whole scene as commented TOML; [`Scene::parse`] reads it back to the same bits.
    pub fn to_toml(&self) -> String {
        let comments = comments();
        let describe = |name: &str| comments.get(name).map_or("", String::as_str);
        let mut scene = self.clone();
        let mut text = String::new();
        for section in SECTIONS {
            let line = if text.is_empty() { "" } else { "\n" };
            text += &format!(
                "{line}# {}\n[{}]\n",
                describe(section.settings),
                section.name
            );
            for field in section.fields {
                let comment = describe(&format!("{}.{}", section.settings, field.key));
                let slot = (field.slot)(&mut scene);
                // Writing to a String cannot fail.
                let _ = writeln!(
                    text,
                    "# {comment} Allowed: {}.",
                    slot.allowed(&field.limits)
                );
                let _ = writeln!(text, "{} = {slot}", field.key);
            }
        }
        text
    }
}

/// The structs' documentation, by `Settings` and `Settings.key`, taken from their source: the
/// sentence that describes a key in a scene file is the one that describes the field, and cannot
/// drift from it.
fn comments() -> HashMap<String, String> {
    let sources = [
        include_str!("robot.rs"),
        include_str!("design.rs"),
        include_str!("optimisation.rs"),
        include_str!("beyond.rs"),
    ];
    let mut comments = HashMap::new();
    let (mut settings, mut comment) = ("", String::new());
    for line in sources.iter().flat_map(|source| source.lines()) {
        let line = line.trim();
        if let Some(text) = line.strip_prefix("///") {
            comment += text;
        } else if let Some(item) = line.strip_prefix("pub ") {
            let name = item.trim_start_matches("struct ");
            let name = name.split([':', ' ']).next().unwrap_or(name);
            let is_struct = item.starts_with("struct ");
            settings = if is_struct { name } else { settings };
            let path = if is_struct {
                name.to_string()
            } else {
                format!("{settings}.{name}")
            };
            comments.insert(path, std::mem::take(&mut comment).trim().to_string());
        } else if !line.starts_with('#') {
            comment.clear();
        }
    }
    comments
}
