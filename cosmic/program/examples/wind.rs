//! A force that depends on place and time: gusts that run along the ground and are stronger higher up.
//!
//! `cargo run --release -p cosmic-program --example wind -- optimize --iterations 8 --out runs/wind`

use std::f64::consts::TAU;
use std::process::ExitCode;

use autodiff::Real;
use cosmic::geometry::Vector;
use cosmic::kernel;
use cosmic::laws::{Law, Node, NodeForce, on_nodes};
use cosmic::settings::within;
use cosmic_program::Program;

cosmic::settings! {
    /// Gusts of wind: each node is dragged along with the air around it.
    struct Wind<R> {
        /// Speed of the air a metre above the ground, at the peak of a gust.
        speed: R = -1.0, allowed within(-50.0, 50.0), unit "m/s", source "an example";
        /// Drag of a node.
        drag: R = 0.01, allowed within(0.0, 10.0), unit "N s/m", source "an example";
        /// Time from gust to gust.
        period: R = 2.0, allowed within(1e-3, 1e3), unit "s", source "an example";
        /// Distance from gust to gust.
        wavelength: R = 3.0, allowed within(1e-3, 1e3), unit "m", source "an example";
    }
}

impl Law for Wind {
    const NAME: &'static str = "wind";
}

#[kernel]
impl NodeForce for Wind {
    const NEEDS_TIME: bool = true;

    fn force<R: Real, const D: usize>(wind: &Wind<R>, node: Node<R, D>) -> Vector<R, D> {
        let along = node.x.forward() * R::lit(TAU) / wind.wavelength;
        let phase = node.time * R::lit(TAU) / wind.period - along;
        let gust = R::lit(0.5) + R::lit(0.5) * phase.sin();
        let air = Vector::upright(wind.speed * node.x.up() * gust, R::zero());
        (air - node.v) * wind.drag
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[physics]\nforces = [\"wind\"]\n[wind]\nspeed = -0.5";
    Program::new()
        .with_law(on_nodes::<Wind>())
        .with_scene("wind", scene)
        .run()
}
