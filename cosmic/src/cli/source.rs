//! What the commands that run one robot are given: a case, a design or a scene.

use crate::case::Case;
use crate::error::{Error, Result};
use crate::reading::read_whole;
use crate::record::run::{DESIGN, SCENE};
use crate::record::{DesignFile, design_file};
use crate::scene::{BUILTIN, Scene};
use std::path::{Path, PathBuf};

/// The seed of the controller that a scene is tried out with.
const SEED: u64 = 0;

/// A robot, before it is read.
#[derive(Debug, PartialEq)]
pub(super) enum Source {
    /// The name of a built-in scene, or a TOML file.
    Scene(String),
    /// A run's design; its scene is beside it.
    Design(PathBuf),
    /// A case, with its text.
    Case(String, String),
}

impl Source {
    /// Finds out which of them a name stands for: a built-in scene by its name, a run's folder by the
    /// design in it, the files by what they hold.
    pub(super) fn find(name: &str) -> Result<Self> {
        if BUILTIN.iter().any(|builtin| builtin.name == name) {
            return Ok(Self::Scene(name.to_owned()));
        }
        let path = Path::new(name);
        if path.is_dir() {
            return Ok(Self::Design(path.join(DESIGN)));
        }
        let text = match read_whole(path) {
            Ok(bytes) => String::from_utf8_lossy(&bytes).into_owned(),
            // A name that is no file may be a misspelt scene: that reader has a hint.
            Err(Error::Read { source, .. })
                if source.kind() == std::io::ErrorKind::NotFound && !is_json(path) =>
            {
                return Ok(Self::Scene(name.to_owned()));
            }
            Err(error) => return Err(error),
        };
        Ok(Self::recognise(path, text))
    }

    fn recognise(path: &Path, text: String) -> Self {
        let name = path.display().to_string();
        if !is_json(path) && !text.trim_start().starts_with('{') {
            return Self::Scene(name);
        }
        // Not by parsing: a truncated design is a design too, and its reader says what is wrong.
        if text.contains(&format!("\"{}\"", design_file::FORMAT.name)) {
            return Self::Design(path.to_owned());
        }
        Self::Case(name, text)
    }

    /// Reads the robot.
    pub(super) fn case(&self) -> Result<Case> {
        match self {
            Self::Scene(name) => Case::of_scene(&Scene::load(name)?, SEED),
            Self::Design(path) => {
                let design = DesignFile::read(path)?;
                let scene = Scene::read(&path.with_file_name(SCENE))?;
                design.case(&scene, &path.display().to_string())
            }
            Self::Case(name, text) => Case::parse(name, text),
        }
    }
}

fn is_json(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension == "json")
}
