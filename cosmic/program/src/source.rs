//! Reads a robot from a reference case, a design or a scene, for the commands that roll out one robot.

use crate::arguments::Settings;
use cosmic::Registry;
use cosmic::case::Case;
use cosmic::design::Design;
use cosmic::error::{Error, Result, in_shell};
use cosmic::outcome::DesignFile;
use cosmic::policy::Controller;
use cosmic::reading::{MARK, placed, read_whole, text_of};
use cosmic::record::damaged::explained;
use cosmic::record::run::{DESIGN, read_scene};
use cosmic::record::summary::result_of;
use cosmic::scene::Scene;
use std::path::{Path, PathBuf};

/// A robot that is read from a scene has no trained controller. This is the seed for its random weights.
const SEED: u64 = 0;

/// A robot that a command can simulate.
pub(super) struct Source {
    pub(super) case: Case,
    /// The robot's scene; `None` if the robot comes from a reference case.
    pub(super) scene: Option<Scene>,
    /// True for the robot of a run or a design, false for a scene or a case.
    pub(super) is_delivered: bool,
}

impl Source {
    /// Reads the robot that `name` stands for. It may be a built-in scene, the folder of a run, or a file. The content
    /// of a file shows whether it is a scene, a design or a case. A file is read only once, because it may be a pipe.
    pub(super) fn read(name: &str, settings: &Settings, registry: &Registry) -> Result<Self> {
        let path = Path::new(name);
        let is_builtin = registry.scene(name).is_some();
        // If there is no such file, the name may be that of a misspelt scene. The reader of scenes then suggests the
        // right name.
        if is_builtin || !is_json(path) && !path.exists() {
            return Self::of_scene(settings.load(name, registry)?);
        }
        if path.is_dir() {
            let (design, bytes) = read_design(path)?;
            return Self::of_design(&design, &bytes, settings, registry);
        }
        Self::of_bytes(path, &read_whole(path)?, settings, registry)
    }

    fn of_bytes(
        path: &Path,
        bytes: &[u8],
        settings: &Settings,
        registry: &Registry,
    ) -> Result<Self> {
        let file = path.display().to_string();
        let unmarked = bytes.strip_prefix(MARK.as_bytes()).unwrap_or(bytes);
        let begins_as_json = unmarked.trim_ascii_start().starts_with(b"{");
        if !is_json(path) && !begins_as_json {
            if let Some(kind) = kind_of_result(path) {
                return Err(no_robot(path, kind));
            }
            let scene = registry.parse_file(&file, text_of(&file, bytes)?)?;
            return Self::of_scene(scene.set(&settings.set)?);
        }
        let text = text_of(&file, bytes)?;
        // The text is not parsed as JSON here. It may be a truncated design, for which the reader of designs has a
        // better error.
        let format = format_of(text).unwrap_or_default();
        if format == DesignFile::FORMAT.name {
            return Self::of_design(path, bytes, settings, registry);
        }
        let other = OTHERS.iter().find(|(name, _)| *name == format);
        if let Some((_, kind)) = other {
            return Err(no_robot(path, kind));
        }
        settings.refuse(&format!("{file} is a reference case, which has no scene"))?;
        Ok(Self {
            case: Case::parse_with(registry, &file, text)?,
            scene: None,
            is_delivered: false,
        })
    }

    fn of_scene(scene: Scene) -> Result<Self> {
        Ok(Self {
            case: Case::of_scene(&scene, SEED)?,
            scene: Some(scene),
            is_delivered: false,
        })
    }

    /// Reads the robot of a design file, and the scene beside that file.
    fn of_design(
        path: &Path,
        bytes: &[u8],
        settings: &Settings,
        registry: &Registry,
    ) -> Result<Self> {
        let design = DesignFile::parse(path, bytes).map_err(explained(path))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let scene = read_scene(folder, registry)?.set(&settings.set)?;
        Ok(Self {
            case: fitted((path, bytes), |file| design.case(&scene, file))?,
            scene: Some(scene),
            is_delivered: true,
        })
    }
}

/// The formats of files that contain no robot, each with a description.
const OTHERS: [(&str, &str); 8] = [
    ("cosmic-summary", "the summary of a run"),
    ("cosmic-snapshot", "the saved state of a run"),
    ("cosmic-history", "the history of a run"),
    ("cosmic-designs", "the history of a run's designs"),
    ("cosmic-trajectory", "the motion of a robot"),
    ("cosmic-sweep", "the plan of a sweep"),
    ("cosmic-truss", "a lattice for `lattice.file` of a scene"),
    ("cosmic-mujoco", "a controller for MuJoCo"),
];

/// Names the kind of a result file (table, page or picture) by its file extension; `None` for other files.
fn kind_of_result(path: &Path) -> Option<&'static str> {
    Some(match path.extension()?.to_str()? {
        "csv" => "a table",
        "html" => "a page",
        "svg" | "gif" | "mp4" => "a picture",
        _ => return None,
    })
}

/// Makes the error for a file that contains no robot. If the file is in the folder of a run, the error says that the
/// robot is in that folder.
fn no_robot(path: &Path, kind: &str) -> Error {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let folder = folder.unwrap_or(Path::new("."));
    let advice = if folder.join(DESIGN).exists() {
        format!("the robot of this run is in {}", in_shell(folder))
    } else {
        "name the folder of a run, a design.json, a reference case or a scene".to_owned()
    };
    Error::Usage(format!(
        "{} is {kind} and contains no robot; {advice}",
        path.display()
    ))
}

/// Finds the first key `format` in a JSON text, which may be truncated, and returns its value.
fn format_of(text: &str) -> Option<&str> {
    let mut pieces = text.split('"');
    while pieces.by_ref().any(|piece| piece == "format") {
        if pieces.clone().next()?.trim() == ":" {
            return pieces.nth(1);
        }
    }
    None
}

/// Calls `make` with the name of a design file. If `make` returns an error about a key of the design, adds to the error
/// where the key is in the file.
fn fitted<T>((path, bytes): (&Path, &[u8]), make: impl FnOnce(&str) -> Result<T>) -> Result<T> {
    let file = &path.display().to_string();
    let text = String::from_utf8_lossy(bytes);
    make(file).map_err(|error| placed(file, &text, error))
}

/// Reads the robot in a run's folder or a design file, and checks that it fits `scene`.
pub(super) fn robot(name: &Path, scene: &Scene) -> Result<(Design<[f64; 3]>, Controller<f64>)> {
    let (path, bytes) = read_design(name)?;
    let design = DesignFile::parse(&path, &bytes).map_err(explained(&path))?;
    fitted((&path, &bytes), |file| {
        let case = design.case(scene, file)?;
        Ok((case.design, case.controller))
    })
}

/// Reads a design file, or the design in a run's folder. Returns the path and the content.
fn read_design(path: &Path) -> Result<(PathBuf, Vec<u8>)> {
    let design = design_path(path)?;
    let bytes = read_whole(&design)?;
    Ok((design, bytes))
}

/// Finds the design in a run's folder, or returns `path` itself if it is not a folder.
///
/// # Errors
/// [`Error::Read`] if the folder has no design, with the reason and a remedy.
pub(super) fn design_path(path: &Path) -> Result<PathBuf> {
    if path.is_dir() {
        return result_of(path, DESIGN);
    }
    Ok(path.to_owned())
}

/// The path of the design in a run's folder, or `path` itself if it is not a folder.
pub(super) fn design_of(path: &Path) -> PathBuf {
    if path.is_dir() {
        path.join(DESIGN)
    } else {
        path.to_owned()
    }
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|name| name == "json")
}

/// The name of a scene: its file name without the extension, or its built-in name.
pub(super) fn name_of(scene: &Path) -> String {
    let name = scene.file_stem().unwrap_or(scene.as_os_str());
    name.to_string_lossy().into_owned()
}
