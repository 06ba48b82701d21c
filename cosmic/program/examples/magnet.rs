//! A magnet that pulls only the nodes in the top row of the lattice.
//!
//! `cargo run --release -p cosmic-program --example magnet -- optimize --iterations 8 --out runs/magnet`

use std::process::ExitCode;

use autodiff::Real;
use cosmic::geometry::Vector;
use cosmic::kernel;
use cosmic::lattice::Lattice;
use cosmic::laws::{Law, Node, NodeForce, on_nodes};
use cosmic::settings::within;
use cosmic_program::Program;

cosmic::settings! {
    /// A magnet. The nodes of the top row are made of iron.
    struct Magnet<R> {
        /// Position: distance along the ground, and height above it.
        place: [R; 2] = [3.0, 1.0], allowed within(-1e3, 1e3), unit "m", source "an example";
        /// Pull at a distance of a metre.
        pull: R = 0.02, allowed within(0.0, 1e3), unit "N", source "an example";
        /// Size of the magnet. At distances below it, the pull fades.
        size: R = 0.3, allowed within(1e-3, 1e2), unit "m", source "an example";
    }
}

impl Law for Magnet {
    const NAME: &'static str = "magnet";
}

#[kernel]
impl NodeForce for Magnet {
    fn weight(&self, node: usize, lattice: &Lattice) -> f64 {
        let height = |node: usize| lattice.places[node].up();
        let top = (0..lattice.nodes()).map(height).fold(f64::MIN, f64::max);
        f64::from(u8::from(top - height(node) < 1e-9))
    }

    fn force<R: Real, const D: usize>(magnet: &Magnet<R>, node: Node<R, D>) -> Vector<R, D> {
        let [along, above] = magnet.place;
        let d = Vector::upright(along, above) - node.x;
        let square = d.dot(d) + magnet.size * magnet.size;
        d * (node.weight * magnet.pull * square.rsqrt() / square)
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[physics]\nforces = [\"magnet\"]";
    Program::new()
        .with_law(on_nodes::<Magnet>())
        .with_scene("magnet", scene)
        .run()
}
