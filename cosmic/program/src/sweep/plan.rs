//! `cosmic sweep plan`.

use crate::arguments::{Output, Settings, count, seed};
use crate::output::answer_planned;
use crate::source::name_of;
use clap::Args;
use cosmic::Registry;
use cosmic::error::Result;
use cosmic::scene::BUILTIN;
use cosmic_lab::sweep::{SweepPlan, on_grid};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Plan {
    /// Built-in scenes or TOML files
    #[arg(value_name = "SCENE", default_value = BUILTIN[0].name)]
    scenes: Vec<String>,
    #[command(flatten)]
    settings: Settings,
    /// Plan every scene with each of these values, as in `--grid physics.friction=0.6,1`; repeat it for all
    /// combinations of several keys
    #[arg(long, value_name = "KEY=V,V...")]
    grid: Vec<String>,
    /// Seeds per scene
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    seeds: NonZeroUsize,
    /// The first seed
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    first_seed: u64,
    /// Fit the phases of every scene into this many iterations
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<NonZeroUsize>,
    /// The folder of the sweep, new or empty
    #[arg(long, value_name = "S")]
    out: PathBuf,
    #[command(flatten)]
    output: Output,
}

impl Plan {
    pub(super) fn freeze(&self, registry: &Registry) -> Result<()> {
        let named = |scene: &String| Ok((name_of(Path::new(scene)), registry.load(scene)?));
        let scenes: Vec<_> = self.scenes.iter().map(named).collect::<Result<_>>()?;
        let plan = SweepPlan {
            study: None,
            first_seed: self.first_seed,
            seeds: self.seeds,
            iterations: self.iterations,
            scenes: on_grid(&scenes, &self.settings.set, &self.grid)?,
        };
        plan.freeze(&self.out, registry)?;
        answer_planned(&self.output, &self.out, plan.runs())
    }
}
