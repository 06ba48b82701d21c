//! Viscous ground: while a node touches the mud, its velocity decays gradually. Friction would reduce the velocity at
//! once.
//!
//! `cargo run --release -p cosmic-program --example mud -- optimize --iterations 8 --out runs/mud`

use std::process::ExitCode;

use autodiff::Real;
use cosmic::geometry::Vector;
use cosmic::kernel;
use cosmic::laws::{Contact, Impact, Law, contact};
use cosmic::settings::within;
use cosmic_program::Program;

cosmic::settings! {
    /// Muddy ground, which slows down every node that touches it.
    struct Mud<R> {
        /// Rate at which a velocity along the ground decays.
        rate: R = 500.0, allowed within(0.0, 1e5), unit "1/s", source "an example";
    }
}

impl Law for Mud {
    const NAME: &'static str = "mud";
}

#[kernel]
impl Contact for Mud {
    fn respond<R: Real, const D: usize>(mud: &Mud<R>, impact: Impact<R, D>) -> Vector<R, D> {
        let left = (-mud.rate * impact.rest).exp();
        impact.velocity.along() * left
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[physics]\ncontact = \"mud\"\n[mud]\nrate = 300.0";
    Program::new()
        .with_law(contact::<Mud>())
        .with_scene("mud", scene)
        .run()
}
