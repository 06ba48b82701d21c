//! Designs a robot of a built-in scene and prints its `design.json`, to be compared with the page's.
//!
//!     RUSTFLAGS='--cfg unoptimised' cargo run --release --example design -- stability 0 [KEY=VALUE...]
//!
//! With that flag the library uses no SIMD registers, and like WebAssembly has no fused multiply-add but that of the
//! elementary functions.

use cosmic::codesign::CoDesign;
use cosmic::record::DesignFile;
use cosmic::scene::Scene;

fn main() -> cosmic::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, seed, settings @ ..] = &arguments[..] else {
        panic!("usage: design SCENE SEED [KEY=VALUE...]");
    };
    let seed = seed.parse().expect("a seed is a whole number");
    let mut codesign = CoDesign::new(&Scene::load(scene)?.set(settings)?)?;
    let robot = codesign.optimise(seed, |_| ())?;
    let lattice = &codesign.task().lattice;
    let file = DesignFile::new(lattice, &robot.z, &robot.materials, &robot.controller);
    print!("{}", file.to_json());
    Ok(())
}
