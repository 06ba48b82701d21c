//! The base of a scene: a built-in scene that supplies the keys that are missing in the scene's file.

use super::Scene;

/// The value of the key `format` in the scene of a run.
pub(super) const FORMAT: &str = "cosmic-scene";

/// The version of the scenes that this program writes for runs, and reads.
pub(super) const VERSION: u32 = 1;

/// The keys that a scene file may have above its first section.
pub(super) const TOP_KEYS: [&str; 3] = ["format", "version", "base"];

/// A built-in scene that supplies the keys that are missing in a scene file. It is `earth` unless the file names
/// another base.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Base(pub(super) &'static str);

impl Base {
    /// The base that consists of the declared defaults: the paper's scene, `stability`.
    pub(super) const DECLARED: Base = Base("stability");

    /// The name of the built-in scene.
    pub fn name(self) -> &'static str {
        self.0
    }
}

impl Default for Base {
    fn default() -> Self {
        Base("earth")
    }
}

impl Scene {
    /// The paper's scene for design b: the built-in scene `stability`, which consists of the declared defaults.
    pub fn paper() -> Scene {
        Scene::declared(Base::DECLARED)
    }
}
