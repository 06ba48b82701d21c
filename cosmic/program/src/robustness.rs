//! `cosmic robustness`.

use crate::arguments::{Settings, Work, number, seed, whole};
use crate::output::answer;
use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::parallel::pool;
use cosmic::scene::{RobustSettings, Scatter};
use cosmic::walk::Divergence;
use cosmic_lab::robustness::{DrawnVariations, measure};
use std::path::PathBuf;

/// Simulate finished designs with random starts, friction, stiffness and masses
///
/// Every design gets the same random draws.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folders of the runs
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Number of random draws
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = whole(1..=u16::MAX), allow_negative_numbers = true)]
    samples: u16,
    /// Seed of the draws
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// Maximum change of a coordinate at the start, m
    #[arg(long, value_name = "M", default_value_t = RobustSettings::default().scatter().start, value_parser = up_to(1.0), allow_negative_numbers = true)]
    start: f64,
    /// Maximum relative change of the coefficient of Coulomb friction
    #[arg(long, value_name = "SHARE", default_value_t = RobustSettings::default().scatter().friction, value_parser = up_to(MOST), allow_negative_numbers = true)]
    friction: f64,
    /// Maximum relative change of the stiffness of an edge
    #[arg(long, value_name = "SHARE", default_value_t = RobustSettings::default().scatter().stiffness, value_parser = up_to(MOST), allow_negative_numbers = true)]
    stiffness: f64,
    /// Maximum relative change of the mass of a node
    #[arg(long, value_name = "SHARE", default_value_t = RobustSettings::default().scatter().mass, value_parser = up_to(MOST), allow_negative_numbers = true)]
    mass: f64,
    /// Simulate all designs in this built-in scene or TOML file instead of their own scenes
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    work: Work,
}

/// The largest relative change that the user may ask for. It is below 1, so that positive numbers stay positive.
const MOST: f64 = 0.99;

/// Makes a parser for numbers from 0 to `most`.
fn up_to(most: f64) -> impl Fn(&str) -> std::result::Result<f64, String> + Clone {
    move |text| {
        let expected = format!("expected a number from 0 to {most}");
        number(text, |x| (0.0..=most).contains(&x), expected)
    }
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let scatter = Scatter {
            start: self.start,
            friction: self.friction,
            stiffness: self.stiffness,
            mass: self.mass,
        };
        let variations = DrawnVariations {
            samples: self.samples.into(),
            scatter,
            seed: self.seed,
            scene: match &self.scene {
                Some(name) => Some(registry.load(name)?),
                None => None,
            },
            settings: self.settings.set.clone(),
            registry: registry.clone(),
        };
        let pool = pool(self.work.threads)?;
        let found = pool.install(|| measure(&self.runs, &variations))?;
        answer(&self.work.output, &found, &found.table().to_text())?;
        judge(&found.divergences)
    }
}

/// Returns an error if a robot diverges even without random changes. The error has a line for each such robot.
fn judge(divergences: &[(String, Divergence)]) -> Result<()> {
    let place = |(run, divergence): &(String, Divergence)| {
        let place = Error::from(divergence);
        format!("{run}: the nominal robot {place}")
    };
    let places: Vec<String> = divergences.iter().map(place).collect();
    if places.is_empty() {
        return Ok(());
    }
    Err(Error::NoFigure(places.join("\n")))
}
