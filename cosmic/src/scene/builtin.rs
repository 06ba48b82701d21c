//! The built-in scenes, and finding a scene by name or file.

use super::Scene;
use super::base::Base;
use super::diagnostic::{SceneText, not_text};
use super::read::{options, pointed, suggest};
use crate::error::{Error, Result};
use crate::reading::{read_at_most, too_long};
use crate::registry::Registry;
use std::io::ErrorKind;
use std::path::Path;

/// A scene that ships with the crate.
#[derive(Debug, Clone, Copy)]
pub struct Builtin {
    /// The name it is asked for by.
    pub name: &'static str,
    /// The scene's TOML: the settings that differ from its base.
    pub text: &'static str,
}

/// The beginning of the line that names a built-in scene's base.
const BASE_LINE: &str = "base = ";

impl Builtin {
    /// The file's first line, which says what the scene is.
    pub fn about(&self) -> &'static str {
        let first = self.text.lines().next().unwrap_or_default();
        first.trim_start_matches('#').trim()
    }

    /// The scene's TOML without its base, for [changing](Scene::with) another scene.
    pub fn changes(&self) -> String {
        let lines = self.text.lines();
        let keep = |line: &str| {
            if line.starts_with(BASE_LINE) {
                ""
            } else {
                line
            }
            .to_owned()
        };
        lines.map(|line| keep(line) + "\n").collect()
    }
}

impl Base {
    /// The base with this name. Only scenes that ship with the crate can be bases.
    pub fn named(name: &str) -> Option<Base> {
        let builtin = BUILTIN.iter().find(|builtin| builtin.name == name);
        builtin.map(|builtin| Base(builtin.name))
    }

    /// The names of all bases.
    pub(super) fn names() -> [&'static str; BUILTIN.len()] {
        BUILTIN.map(|builtin| builtin.name)
    }

    /// The base's scene, whose base is itself.
    ///
    /// # Panics
    /// If a built-in scene is invalid; a test reads them all.
    pub fn scene(self) -> Scene {
        if self == Base::DECLARED {
            return Scene::paper();
        }
        let mut builtins = BUILTIN.iter();
        let builtin = builtins.find(|builtin| builtin.name == self.name());
        let scene = builtin.map(|builtin| Scene::parse(builtin.name, builtin.text));
        let scene = scene
            .and_then(|scene| scene.ok())
            .expect("a built-in scene");
        Scene {
            base: self,
            ..scene
        }
    }
}

/// The built-in scene `earth`.
impl Default for Scene {
    fn default() -> Self {
        Base::default().scene()
    }
}

/// Scenes of the folder `scenes` by their names.
macro_rules! builtin {
    ($($name:literal),+ $(,)?) => {
        [$(Builtin {
            name: $name,
            text: include_str!(concat!("../../scenes/", $name, ".toml")),
        }),+]
    };
}

/// All built-in scenes; the program's default comes first. The base of each is `stability`.
pub const BUILTIN: [Builtin; 13] = builtin![
    "earth",
    "stability",
    "baseline_tall",
    "baseline_short",
    "three_legged",
    "uniform",
    "incline",
    "five_by_five",
    "coulomb",
    "tilted",
    "steps",
    "rough",
    "large",
];

/// The scenes that this process was given beside those that ship with the crate.
static ADDED: Registry<Builtin> = Registry::new();

/// Gives this process a scene with a name. The last one given is what an omitted scene means.
///
/// # Panics
/// If there is a scene of that name already.
pub fn add(name: &'static str, text: &'static str) {
    let is_built_in = BUILTIN.iter().any(|builtin| builtin.name == name);
    assert!(!is_built_in, "there is a scene {name:?} already");
    ADDED.add("scene", name, Builtin { name, text });
}

/// Every scene with a name, the default first: those [given](add), then the [`BUILTIN`] ones.
pub fn all() -> Vec<Builtin> {
    let added = ADDED.all().into_iter().rev().map(|(_, scene)| scene);
    added.chain(BUILTIN).collect()
}

/// The scene of a name, if there is one.
pub fn named(name: &str) -> Option<Builtin> {
    all().into_iter().find(|builtin| builtin.name == name)
}

/// The largest scene file read; a complete scene has some ten thousand bytes.
const LARGEST: u64 = 1 << 20;

impl Scene {
    /// The scene of that built-in name, or else in that TOML file.
    ///
    /// # Errors
    /// [`Error::NoScene`] where there is neither, otherwise those of [`Scene::read`].
    pub fn load(name: &str) -> Result<Scene> {
        if let Some(base) = Base::named(name) {
            return Ok(base.scene());
        }
        if let Some(added) = named(name) {
            return Scene::parse(added.name, added.text);
        }
        Scene::read(Path::new(name)).map_err(|error| match error {
            Error::Read { path, source }
                if source.kind() == ErrorKind::NotFound && path == Path::new(name) =>
            {
                Error::NoScene {
                    name: name.to_string(),
                    hint: suggest(name, all().iter().map(|builtin| builtin.name)),
                }
            }
            other => other,
        })
    }

    /// The scene in a TOML file.
    ///
    /// # Errors
    /// [`Error::Read`] for a file that cannot be read, [`Error::Usage`] for one that is far too
    /// long, [`Error::Malformed`] for one that is not UTF-8, and those of [`Scene::parse`].
    pub fn read(path: &Path) -> Result<Scene> {
        Scene::parse(&path.display().to_string(), &Scene::text(path)?)
    }

    /// The text of a scene file.
    ///
    /// # Errors
    /// The errors of [`read`](Scene::read), except for faults that parsing finds.
    pub fn text(path: &Path) -> Result<String> {
        text_of(path, &read_at_most(path, LARGEST)?).map(str::to_owned)
    }

    /// Parses the bytes of a scene file; messages name `path`.
    ///
    /// # Errors
    /// [`Error::Usage`] for far too many bytes, [`Error::Malformed`] for some that are not UTF-8,
    /// and those of [`Scene::parse`].
    pub fn of_bytes(path: &Path, bytes: &[u8]) -> Result<Scene> {
        Scene::parse(&path.display().to_string(), text_of(path, bytes)?)
    }
}

fn text_of<'b>(path: &Path, bytes: &'b [u8]) -> Result<&'b str> {
    if bytes.len() as u64 > LARGEST {
        return Err(too_long(path, LARGEST));
    }
    std::str::from_utf8(bytes).map_err(|_| not_text(&path.display().to_string(), bytes))
}

/// The error for a setting that turned out wrong after reading, shown with its remedy where it was
/// set: by one of `settings`, as [`Scene::set`] takes them, else in the scene of that name or file;
/// `None` where none of them sets it.
pub fn fault(
    name: &str,
    settings: &[impl AsRef<str>],
    key: &str,
    message: &str,
    remedy: &str,
) -> Option<Error> {
    let builtin = named(name);
    let path = Path::new(name);
    let text = match builtin {
        Some(builtin) => Some(builtin.text.to_owned()),
        // A pipe cannot be read again: opening it might wait for a writer for good.
        None if path.is_file() => Scene::text(path).ok(),
        None => None,
    };
    let file = text.as_deref().map(|text| SceneText::file(name, text));
    let sources: Vec<_> = file.into_iter().chain(options(settings)).collect();
    pointed(&sources, key, message, remedy)
}
