//! A force along bars, as if a piece of rubber were beside every bar. Depending on a setting, the rubber resists
//! stretching or shortening of the bar, and is slack otherwise.
//!
//! The law is added to the bar's spring; it does not replace the spring.
//!
//! `cargo run --release -p cosmic-program --example tendon -- optimize --iterations 8 --out runs/tendon`

use std::process::ExitCode;

use autodiff::Real;
use cosmic::kernel;
use cosmic::laws::{Bar, BarForce, Law, on_bars};
use cosmic::settings::within;
use cosmic_program::Program;

cosmic::settings! {
    /// The change of length that a tendon resists.
    enum Side {
        /// A rubber band: it resists stretching.
        Stretched = "stretched",
        /// A rubber buffer: it resists shortening.
        Shortened = "shortened",
    }
}

cosmic::settings! {
    /// Rubber beside every bar.
    struct Tendon<R> {
        /// Whether the rubber resists stretching or shortening.
        side: Side = Side::Stretched, source "an example";
        /// Stiffness of the rubber.
        stiffness: R = 20.0, allowed within(0.0, 1e4), unit "N/m", source "an example";
        /// Strain of the bar up to which the rubber is slack.
        slack: R = 0.1, allowed within(0.0, 0.9), source "an example";
    }
}

impl Law for Tendon {
    const NAME: &'static str = "tendon";
}

#[kernel]
impl BarForce for Tendon {
    fn tension<R: Real>(tendon: &Tendon<R>, bar: Bar<R>) -> R {
        // For a void bar, which has almost no stiffness, this factor is close to 0. So a void bar gets no rubber.
        let share = bar.stiffness / (bar.stiffness + R::lit(1.0));
        let change = bar.length - bar.rest_length;
        let slack = tendon.slack * bar.rest_length;
        // A law may branch on its settings. A choice that depends on a `Real` must use a selection such as `max`
        // instead.
        let pulled = match tendon.side {
            Side::Stretched => (change - slack).max(R::zero()),
            Side::Shortened => -(-change - slack).max(R::zero()),
        };
        tendon.stiffness * share * pulled
    }
}

fn main() -> ExitCode {
    let scene = "[physics]\nforces = [\"tendon\"]\n[tendon]\nside = \"shortened\"";
    Program::new()
        .with_law(on_bars::<Tendon>())
        .with_scene("tendon", scene)
        .run()
}
