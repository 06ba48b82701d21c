//! The base of a scene: where the keys come from that its file lacks.

use super::Scene;

/// The name of a built-in scene that supplies missing keys; `earth` where a file names none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Base(pub(super) &'static str);

impl Base {
    /// The scene that the declared defaults make: the paper's.
    pub(super) const DECLARED: Base = Base("stability");

    /// The scene's name.
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
    /// The paper's design b: the built-in scene `stability`, which the declared defaults make.
    pub fn paper() -> Scene {
        Scene::declared(Base::DECLARED)
    }
}
