//! Springs that grow stiffer as they are stretched or compressed.
//!
//! The law adds to the bar's spring what Hooke's law lacks.
//!
//! `cargo run --release -p cosmic-program --example stiffening -- optimize --iterations 8 --out runs/stiffening`

use std::process::ExitCode;

use autodiff::Real;
use cosmic::kernel;
use cosmic::laws::{Bar, BarForce, Law, on_bars};
use cosmic::settings::within;
use cosmic_program::Program;

cosmic::settings! {
    /// Springs grow stiffer as they are stretched or compressed.
    struct Stiffening<R> {
        /// The coefficient `c` of a spring's force `k (e + c e^3)`, where `e` is the change of its length.
        cubic: R = 200.0, allowed within(0.0, 1e6), unit "1/m2", source "an example";
    }
}

impl Law for Stiffening {
    const NAME: &'static str = "stiffening";
}

#[kernel]
impl BarForce for Stiffening {
    fn tension<R: Real>(law: &Stiffening<R>, bar: Bar<R>) -> R {
        let change = bar.length - bar.target;
        law.cubic * bar.stiffness * change * change * change
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        Some(0.25 * self.cubic * bar.stiffness * (bar.length - bar.target).powi(4))
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[physics]\nforces = [\"stiffening\"]";
    Program::new()
        .with_law(on_bars::<Stiffening>())
        .with_scene("stiffening", scene)
        .run()
}
