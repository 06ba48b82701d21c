//! The built-in scenes. Also finds a scene by its name or its file.

use super::Scene;
use super::base::{Base, TOP_KEYS};
use super::diagnostic::{SceneText, suggest};
use super::keys::sections;
use super::text::{options, pointed};
use crate::error::{Error, Result};
use crate::laws::{self, Choice};
use crate::reading::{read_at_most, text_of};
use crate::registry::Registry;
use std::io::{self, ErrorKind};
use std::path::Path;

/// A scene that ships with the crate, or that a program adds.
#[derive(Debug, Clone, Copy)]
pub struct Builtin {
    /// The name by which the scene is chosen.
    pub name: &'static str,
    /// The text of the scene in TOML: the settings that differ from its base.
    pub text: &'static str,
}

impl Builtin {
    /// The description of the scene: the first line of its text.
    pub fn about(&self) -> &'static str {
        let first = self.text.lines().next().unwrap_or_default();
        first.trim_start_matches('#').trim()
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

    /// The built-in scene with the name of this base. This base is also the base of that scene.
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

/// Makes the list of built-in scenes. Each name stands for a file in the folder `scenes`.
macro_rules! builtin {
    ($($name:literal),+ $(,)?) => {
        [$(Builtin {
            name: $name,
            text: include_str!(concat!("../../scenes/", $name, ".toml")),
        }),+]
    };
}

/// All built-in scenes. The first one is the default of the program. The base of each is `stability`, except for
/// `errand`, `workshop` and `cube`, whose base is `earth`, and `scout`, whose base is `cube`.
pub const BUILTIN: [Builtin; 17] = builtin![
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
    "errand",
    "workshop",
    "cube",
    "scout",
];

/// The noun for a scene in messages and in the registry.
const SCENE: &str = "scene";

/// The size of the largest scene file that is read, in bytes. A complete scene has about ten thousand bytes.
const LARGEST: u64 = 1 << 20;

impl Registry {
    /// Adds a law.
    ///
    /// # Panics
    /// If its name does not consist of lower case letters, digits and underscores, or if a law, a section or a key
    /// above the sections of a scene already has that name.
    #[must_use]
    pub fn with_law(self, law: Choice) -> Self {
        let name = law.name();
        let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        assert!(
            name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(is_word),
            "the name of a law consists of lower case letters, digits and underscores, not {name:?}"
        );
        let sections = sections(&mut Scene::paper());
        let mut taken = sections.iter().map(|section| section.name).chain(TOP_KEYS);
        assert!(
            taken.all(|taken| taken != name),
            "a law cannot be named {name:?}: scenes already have a section or key of that name"
        );
        self.with(laws::LAW, &laws::names(), name, law)
    }

    /// Adds a scene. `text` is its TOML. The scene that was added last becomes the default of the program.
    ///
    /// # Panics
    /// If the name is taken.
    #[must_use]
    pub fn with_scene(self, name: &'static str, text: &'static str) -> Self {
        self.with(SCENE, &Base::names(), name, Builtin { name, text })
    }

    /// Every scene that has a name: first the added scenes, then the [`BUILTIN`] ones. The first one is the default.
    pub fn scenes(&self) -> impl Iterator<Item = Builtin> {
        self.all::<Builtin>(SCENE).rev().copied().chain(BUILTIN)
    }

    /// The scene that a command reads if it is given none.
    pub fn default_scene(&self) -> Builtin {
        self.scenes().next().unwrap_or(BUILTIN[0])
    }

    /// The scene with this name, if there is one.
    pub fn scene(&self, name: &str) -> Option<Builtin> {
        self.scenes().find(|builtin| builtin.name == name)
    }

    /// Reads the scene with this name, or else the scene in this TOML file.
    ///
    /// # Errors
    /// [`Error::NoScene`] if there is neither, otherwise the errors of [`read`](Self::read).
    pub fn load(&self, name: &str) -> Result<Scene> {
        if let Some(base) = Base::named(name) {
            return Ok(base.scene().knowing(self));
        }
        if let Some(added) = self.scene(name) {
            return self.parse(added.name, added.text);
        }
        self.read(Path::new(name)).map_err(|error| match error {
            Error::Read { path, source }
                if source.kind() == ErrorKind::NotFound && path == Path::new(name) =>
            {
                Error::NoScene {
                    name: name.to_string(),
                    hint: self.hint(name),
                }
            }
            Error::Read { path, source } if source.kind() == ErrorKind::IsADirectory => {
                let says = "it is a folder; name a scene file, such as the scene.toml in the folder of a run";
                Error::reading(path)(io::Error::other(says))
            }
            other => other,
        })
    }

    /// A hint for a name that no scene has: the most similar name, or all names.
    pub fn hint(&self, name: &str) -> String {
        let names: Vec<_> = self.scenes().map(|builtin| builtin.name).collect();
        suggest(name, names.into_iter())
    }

    /// Reads the scene in a TOML file.
    ///
    /// # Errors
    /// [`Error::Read`] for a file that cannot be read, [`Error::Usage`] for a file that is too long,
    /// [`Error::Malformed`] for a file that is not UTF-8, and the errors of [`parse_file`](Self::parse_file).
    pub fn read(&self, path: &Path) -> Result<Scene> {
        self.parse_file(&path.display().to_string(), &text(path)?)
    }

    /// The error for a setting whose value turned out to be wrong after the scene was read. It has the message, the
    /// remedy, and the place that sets the key: an entry of `settings` (in the form that [`Scene::set`] takes), or a
    /// line of the scene with this name or file. `None` if the key is set nowhere.
    pub fn fault(
        &self,
        name: &str,
        settings: &[impl AsRef<str>],
        key: &str,
        message: &str,
        remedy: &str,
    ) -> Option<Error> {
        let path = Path::new(name);
        let text = match self.scene(name) {
            Some(builtin) => Some(builtin.text.to_owned()),
            // A pipe cannot be read again: opening it might wait for a writer for ever.
            None if path.is_file() => text(path).ok(),
            None => None,
        };
        let file = text.as_deref().map(|text| SceneText::file(name, text));
        let sources: Vec<_> = file.into_iter().chain(options(settings)).collect();
        pointed(self, &sources, key, message, remedy)
    }
}

impl Scene {
    /// Reads the built-in scene with this name, or else the scene in this TOML file, as [`Registry::load`] does.
    ///
    /// # Errors
    /// The errors of [`Registry::load`].
    pub fn load(name: &str) -> Result<Scene> {
        Registry::default().load(name)
    }
}

/// The text of a scene file.
fn text(path: &Path) -> Result<String> {
    let bytes = read_at_most(path, LARGEST)?;
    text_of(&path.display().to_string(), &bytes).map(str::to_owned)
}
