//! The laws of the example programs, as a user adds them.

use cosmic::Registry;
use cosmic::laws::{ForceLaws, contact, on_bars, on_lattice, on_nodes};
use cosmic::scene::Scene;

#[path = "../../cosmic/program/examples/bending.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod bending;
#[path = "../../cosmic/program/examples/buckle.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod buckle;
#[path = "../../cosmic/program/examples/magnet.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod magnet;
#[path = "../../cosmic/program/examples/mud.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod mud;
#[path = "../../cosmic/program/examples/stiffening.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod stiffening;
#[path = "../../cosmic/program/examples/wind.rs"]
#[expect(dead_code, reason = "only its law is used")]
mod wind;

/// A registry with these laws.
pub fn registry() -> Registry {
    Registry::default()
        .with_law(on_bars::<stiffening::Stiffening>())
        .with_law(on_bars::<buckle::Buckle>())
        .with_law(on_lattice::<bending::Bending>())
        .with_law(on_nodes::<magnet::Magnet>())
        .with_law(on_nodes::<wind::Wind>())
        .with_law(contact::<mud::Mud>())
}

/// The paper's scene, changed by settings that may name these laws.
///
/// # Panics
/// If the settings are wrong.
pub fn scene(settings: &str) -> Scene {
    let paper = registry().load("stability").expect("a built-in scene");
    let scene = paper.with("test", settings);
    scene.unwrap_or_else(|error| panic!("{error}"))
}

/// The forces that settings choose, which may name these laws.
///
/// # Panics
/// If the settings are wrong.
pub fn forces(settings: &str) -> ForceLaws {
    scene(settings).physics.forces
}
