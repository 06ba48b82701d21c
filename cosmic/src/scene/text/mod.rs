//! Scenes as text: reads them from TOML, writes them as TOML, and reads their settings from JSON.

mod syntax;
mod read;
mod toml_file;
mod whole;
mod json;
mod write;

pub(crate) use json::JsonSetting;
pub(super) use read::{options, pointed};
pub use toml_file::TomlFile;
