//! What the commands that run one robot are given: a case, a design or a scene.

use cosmic::case::Case;
use cosmic::controller::Controller;
use cosmic::error::{Error, Result};
use cosmic::reading::{MARK, placed, read_whole};
use cosmic::record::run::{DESIGN, SCENE};
use cosmic::record::summary::result_of;
use cosmic::record::{DesignFile, design_file};
use cosmic::scene::{BUILTIN, Scene};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The seed of the controller that a scene is tried out with.
const SEED: u64 = 0;

/// What a robot is read from. All of it is read once: a pipe has no second time.
#[derive(Debug)]
pub(super) enum Source {
    /// A built-in scene, or that of a TOML file.
    Scene(Box<Scene>),
    /// A run's design, with its bytes; its scene is beside it.
    Design(PathBuf, Vec<u8>),
    /// A case, with its text.
    Case(String, String),
}

impl Source {
    /// Finds out which of them a name stands for: a built-in scene by its name, a run's folder by
    /// the design in it, the files by what they hold.
    pub(super) fn find(name: &str) -> Result<Self> {
        let scene = || Ok(Self::Scene(Box::new(Scene::load(name)?)));
        if BUILTIN.iter().any(|builtin| builtin.name == name) {
            return scene();
        }
        let path = Path::new(name);
        if path.is_dir() {
            let (design, bytes) = read_design(path)?;
            return Ok(Self::Design(design, bytes));
        }
        match read_whole(path) {
            Ok(bytes) => Self::recognise(path, bytes),
            // A name that is no file may be a misspelt scene: that reader has a hint.
            Err(Error::Read { source, .. })
                if source.kind() == ErrorKind::NotFound && !is_json(path) =>
            {
                scene()
            }
            Err(error) => Err(error),
        }
    }

    fn recognise(path: &Path, bytes: Vec<u8>) -> Result<Self> {
        let text = String::from_utf8_lossy(&bytes);
        let begins_as_json = || text.trim_start_matches(MARK).trim_start().starts_with('{');
        if !is_json(path) && !begins_as_json() {
            return Ok(Self::Scene(Box::new(Scene::of_bytes(path, &bytes)?)));
        }
        // Not by parsing: a truncated design is a design too, and its reader says what is wrong.
        if is_called(&text, design_file::FORMAT.name) {
            return Ok(Self::Design(path.to_owned(), bytes));
        }
        Ok(Self::Case(path.display().to_string(), text.into_owned()))
    }

    /// The scene, or that beside a design; a case has none.
    pub(super) fn scene(&self) -> Result<Option<Scene>> {
        match self {
            Self::Scene(scene) => Ok(Some((**scene).clone())),
            Self::Design(path, _) => Scene::read(&path.with_file_name(SCENE)).map(Some),
            Self::Case(..) => Ok(None),
        }
    }

    /// Reads the robot.
    pub(super) fn case(&self) -> Result<Case> {
        match self {
            Self::Scene(scene) => Case::of_scene(scene, SEED),
            Self::Design(path, bytes) => {
                let design = DesignFile::parse(path, bytes)?;
                let scene = Scene::read(&path.with_file_name(SCENE))?;
                fitted((path, bytes), |file| design.case(&scene, file))
            }
            Self::Case(name, text) => Case::parse(name, text),
        }
    }
}

/// Whether a JSON text says somewhere that its format is this one.
fn is_called(text: &str, format: &str) -> bool {
    let name = format!("\"{format}\"");
    text.split("\"format\"").skip(1).any(|after| {
        let value = after.trim_start().strip_prefix(':');
        value.is_some_and(|value| value.trim_start().starts_with(&name))
    })
}

/// Something made of a design; what does not fit is pointed at in its file.
fn fitted<T>((path, bytes): (&Path, &[u8]), make: impl FnOnce(&str) -> Result<T>) -> Result<T> {
    let file = &path.display().to_string();
    let text = String::from_utf8_lossy(bytes);
    make(file).map_err(|error| placed(file, &text, error))
}

/// The robot of a run's folder or of a design, for a scene.
pub(super) fn robot(name: &Path, scene: &Scene) -> Result<(Vec<[f64; 3]>, Controller<f64>)> {
    let (path, bytes) = read_design(name)?;
    let design = DesignFile::parse(&path, &bytes)?;
    let controller = fitted((&path, &bytes), |file| design.robot(scene, file))?;
    Ok((design.z, controller))
}

/// The file of a run's design, or of that which a path is of itself, and what is in it.
fn read_design(path: &Path) -> Result<(PathBuf, Vec<u8>)> {
    let design = match path.is_dir() {
        true => result_of(path, DESIGN)?,
        false => path.to_owned(),
    };
    let bytes = read_whole(&design)?;
    Ok((design, bytes))
}

/// The design of a run's folder, or the design that a path is of itself.
pub(super) fn design_of(path: &Path) -> PathBuf {
    match path.is_dir() {
        true => path.join(DESIGN),
        false => path.to_owned(),
    }
}

fn is_json(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension == "json")
}

/// What a scene is called: a file by its name without the extension.
pub(super) fn name_of(scene: &str) -> String {
    let stem = Path::new(scene).file_stem();
    stem.map_or(scene.into(), |stem| stem.to_string_lossy().into_owned())
}
