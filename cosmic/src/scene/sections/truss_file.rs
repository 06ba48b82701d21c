//! The setting `lattice.file`, which names a truss: a lattice with any nodes and edges.

use std::io;
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use toml::Spanned;
use toml::de::DeValue;

use crate::error::{Error, Result};
use crate::lattice::Truss;
use crate::reading::ESCAPE;
use crate::registry::{OFF, Registry};
use crate::settings::{Filled, Limits, SettingValue, json, misfit, word};

/// The setting `lattice.file`. It chooses no truss, the truss in a file, or a truss that was added to the
/// [registry](Registry::with_lattice).
#[derive(Clone, Debug)]
pub struct TrussFile {
    path: String,
    truss: Option<Arc<Truss>>,
    registry: Registry,
}

impl Default for TrussFile {
    fn default() -> Self {
        Self {
            path: OFF.to_owned(),
            truss: None,
            registry: Registry::default(),
        }
    }
}

/// Two settings are equal if their trusses have the same nodes and edges, even if the trusses come from different
/// files.
impl PartialEq for TrussFile {
    fn eq(&self, other: &Self) -> bool {
        match (&self.truss, &other.truss) {
            (None, None) => self.path == other.path,
            (own, others) => own == others,
        }
    }
}

impl Serialize for TrussFile {
    fn serialize<S: serde::Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        to.serialize_str(&self.path)
    }
}

impl TrussFile {
    /// The file name of the copy of the truss that the folder of a run holds.
    pub const COPY: &'static str = "truss.json";

    /// Chooses `truss`. A scene names it by `path`.
    pub fn new(path: &str, truss: Arc<Truss>) -> Self {
        Self {
            path: path.to_owned(),
            truss: Some(truss),
            ..Self::default()
        }
    }

    /// The path of the truss file, or the name of the truss, as the scene states it.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// The chosen truss; `None` for a generated lattice.
    ///
    /// # Panics
    /// If the file was not read yet. Reading a scene reads it.
    pub fn truss(&self) -> Option<&Arc<Truss>> {
        assert!(
            !self.is_to_be_read(),
            "the truss {:?} was not read",
            self.path
        );
        self.truss.as_ref()
    }

    /// True if the setting names a truss that was not read yet.
    pub(in crate::scene) fn is_to_be_read(&self) -> bool {
        self.truss.is_none() && self.path != OFF
    }

    /// Takes the truss with this name from the registry. If there is none, reads the file at this path, which is
    /// relative to `folder`.
    ///
    /// # Errors
    /// The errors of [`Truss::read`].
    pub(in crate::scene) fn resolve(&mut self, folder: &Path) -> Result<()> {
        if !self.is_to_be_read() {
            return Ok(());
        }
        if let Some(truss) = self.registry.lattice(&self.path) {
            self.truss = Some(truss);
            return Ok(());
        }
        let path = folder.join(&self.path);
        let truss = Truss::read(&path).map_err(|error| match error {
            Error::Read { path, source } => {
                let hint = match self.path.contains(char::is_control) {
                    true => format!("; {ESCAPE}"),
                    false => String::new(),
                };
                let says = format!("{source} (the scene's `lattice.file`{hint})");
                let source = io::Error::new(source.kind(), says);
                Error::Read { path, source }
            }
            other => other,
        });
        self.truss = Some(Arc::new(truss?));
        // From now on the path is relative to the working directory.
        self.path = path.display().to_string();
        Ok(())
    }
}

impl SettingValue for TrussFile {
    fn allowed(&self, _: &Limits) -> String {
        "the path of a truss file, or \"off\"".to_owned()
    }

    fn toml(&self) -> String {
        // Rust would escape some characters in another way than TOML.
        toml::Value::String(self.path.clone()).to_string()
    }

    fn json(&self) -> serde_json::Value {
        json(self)
    }

    fn read(&mut self, value: &Spanned<DeValue>, _: &Limits) -> Filled<()> {
        let path = word(value)?;
        if path.is_empty() {
            return Err(misfit(value, "cannot be"));
        }
        (self.path, self.truss) = (path.to_owned(), None);
        Ok(())
    }

    fn know(&mut self, registry: &Registry) {
        self.registry = registry.clone();
    }
}
