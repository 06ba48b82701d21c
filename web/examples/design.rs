//! Designs a robot of a built-in scene and prints its `design.json`, for comparison with the page.
//!
//!     RUSTFLAGS='--cfg unoptimised' cargo run --release --example design -- stability 0 [KEY=VALUE...]
//!
//! With this flag the library uses no SIMD registers. It then computes as WebAssembly does: only the elementary
//! functions use a fused multiply-add.

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
    let file = DesignFile::new(lattice, &robot.design, &robot.materials, &robot.controller);
    print!("{}", file.to_json());
    Ok(())
}
