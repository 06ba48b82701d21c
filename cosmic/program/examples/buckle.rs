//! Slender bars that buckle: they push with at most their Euler load.
//!
//! The law takes from the bar's spring what it would push beyond that.
//!
//! `cargo run --release -p cosmic-program --example buckle -- optimize --iterations 8 --out runs/buckle`

use std::f64::consts::PI;
use std::process::ExitCode;

use autodiff::Real;
use cosmic::kernel;
use cosmic::laws::{Bar, BarForce, Law, on_bars};
use cosmic::settings::above;
use cosmic_program::Program;

cosmic::settings! {
    /// Bars buckle: they push with at most their Euler load.
    struct Buckle<R> {
        /// Bending stiffness `E I` of a bar. With joints at both ends, a bar of the length `l` buckles under
        /// `pi^2 E I / l^2`.
        bending: R = 0.03, allowed above(0.0, 1e9), unit "N m2", source "a carbon rod of 1.5 mm, with 120 GPa";
    }
}

impl Law for Buckle {
    const NAME: &'static str = "buckle";
}

impl<R: Real> Buckle<R> {
    /// The force that the spring lacks, N: it grows with the compression beyond that of the Euler load. At the Euler load
    /// the derivative is that of a bar that has not buckled.
    #[inline(always)]
    fn missing(&self, bar: Bar<R>) -> R {
        let load = R::lit(PI * PI) * self.bending / (bar.rest_length * bar.rest_length);
        (-bar.spring() - load).max(R::zero())
    }
}

#[kernel]
impl BarForce for Buckle {
    fn tension<R: Real>(buckle: &Buckle<R>, bar: Bar<R>) -> R {
        buckle.missing(bar)
    }

    fn energy(&self, bar: Bar<f64>) -> Option<f64> {
        let missing = self.missing(bar);
        Some(match bar.stiffness > 0.0 {
            true => -0.5 * missing * missing / bar.stiffness,
            false => 0.0,
        })
    }
}

fn main() -> ExitCode {
    let scene = "base = \"stability\"\n[physics]\nforces = [\"buckle\"]\n[buckle]\nbending = 0.001";
    Program::new()
        .with_law(on_bars::<Buckle>())
        .with_scene("buckle", scene)
        .run()
}
