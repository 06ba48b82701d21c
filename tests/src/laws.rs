//! The laws of the example programs `stiffening`, `buckle`, `bending` and `mud`, as a user adds them.

use cosmic::Registry;
use cosmic::laws::{ForceLaws, on_bars, on_lattice};
use cosmic::scene::Scene;

#[path = "../../cosmic/program/examples/bending.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod bending;
#[path = "../../cosmic/program/examples/buckle.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod buckle;
#[path = "../../cosmic/program/examples/mud.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod mud;
#[path = "../../cosmic/program/examples/stiffening.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod stiffening;

pub use mud::Mud;

/// A registry with the three laws of forces.
pub fn registry() -> Registry {
    Registry::default()
        .with_law(on_bars::<stiffening::Stiffening>())
        .with_law(on_bars::<buckle::Buckle>())
        .with_law(on_lattice::<bending::Bending>())
}

/// The paper's scene, changed by settings that may name the three laws.
///
/// # Panics
/// If the settings are wrong.
pub fn scene(settings: &str) -> Scene {
    let paper = registry().load("stability").expect("a built-in scene");
    let scene = paper.with("test", settings);
    scene.unwrap_or_else(|error| panic!("{error}"))
}

/// The forces that settings choose, which may name the three laws.
///
/// # Panics
/// If the settings are wrong.
pub fn forces(settings: &str) -> ForceLaws {
    scene(settings).physics.forces
}
