//! `cosmic optimize`.

use super::{RunOptions, runs};
use crate::error::Result;
use crate::record::{Plan, optimise};
use crate::scene::{BUILTIN, Scene};
use clap::Args;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Co-design a robot: structure, material and controller together, by the paper's algorithm 1
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A built-in scene or a TOML file
    #[arg(value_name = "SCENE", default_value = BUILTIN[0].name)]
    scene: String,
    /// Try this many seeds, from --seed on, and keep the best
    #[arg(long, value_name = "N", default_value = "1")]
    starts: NonZeroUsize,
    /// Stop after this many iterations; the phases stay where they are
    #[arg(long, value_name = "N")]
    iterations: Option<NonZeroUsize>,
    #[command(flatten)]
    options: RunOptions,
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let options = &self.options;
        let plan = Plan {
            name: name_of(&self.scene),
            scene: Scene::load(&self.scene)?,
            seed: options.seed,
            starts: self.starts,
            iterations: self.iterations,
        };
        let folder = match &options.out {
            Some(folder) => folder.clone(),
            None => PathBuf::from("runs").join(format!("{}-{}", plan.name, plan.seed)),
        };
        runs::carry_out(&folder, options.threads, &options.output, |observer| {
            optimise(&folder, &plan, observer)
        })
    }
}

/// What a scene is called: a file by its name without the extension.
pub(super) fn name_of(scene: &str) -> String {
    let stem = Path::new(scene).file_stem();
    stem.map_or(scene.into(), |stem| stem.to_string_lossy().into_owned())
}
