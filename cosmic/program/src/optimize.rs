//! `cosmic optimize`.

use crate::arguments::RunOptions;
use crate::runs;
use crate::source::{design_of, name_of, robot};
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use cosmic::codesign::CoDesign;
use cosmic::error::{Error, Result};
use cosmic::record::run::SCENE;
use cosmic::record::{RunPlan, Search, Summary, optimise, optimise_with};
use cosmic::scene::{BUILTIN, Scene, UnstableStep, fault};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Co-design a robot: structure, material and controller together, by the paper's algorithm 1
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A built-in scene or a TOML file [default: stability, with --from the scene beside that
    /// design]
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// Try this many seeds, from --seed on, and keep the best
    #[arg(long, value_name = "N", default_value = "1")]
    starts: NonZeroUsize,
    /// Carry out all starts, or drop weak ones on the way as the scene's [search] says
    #[arg(long, default_value = "full", value_parser = search())]
    search: Search,
    /// Begin with the robot of a run's folder or of a design.json: one that is decided enters after
    /// the snap, for the fine-tuning that is left
    #[arg(long, value_name = "RUN", conflicts_with = "starts")]
    from: Option<PathBuf>,
    /// Stop after this many iterations; the phases stay where they are
    #[arg(long, value_name = "N")]
    iterations: Option<NonZeroUsize>,
    /// Go on although the time step is unstable for the robot (as unstable_step = "warn" in the
    /// scene)
    #[arg(long)]
    allow_unstable: bool,
    #[command(flatten)]
    options: RunOptions,
}

fn search() -> impl TypedValueParser<Value = Search> {
    PossibleValuesParser::new(["full", "halving"]).map(|name| match &*name {
        "halving" => Search::Halving,
        _ => Search::Full,
    })
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let options = &self.options;
        let [from, name] = self.sources();
        let mut scene = Scene::load(&from)?;
        if self.allow_unstable {
            scene.physics.unstable_step = UnstableStep::Warn;
        }
        let plan = RunPlan {
            name,
            scene,
            seed: options.seed,
            starts: self.starts,
            iterations: self.iterations,
            search: self.search,
        };
        if plan.search == Search::Halving && plan.starts.get() == 1 {
            return Err(Error::Usage(
                "--search halving drops the weak ones of several starts: add --starts N".into(),
            ));
        }
        let folder = match &options.out {
            Some(folder) => folder.clone(),
            None => PathBuf::from("runs").join(self.folder_name(&plan)),
        };
        let robot = self.from.as_deref().map(|from| robot(from, &plan.scene));
        let robot = robot.transpose()?;
        runs::carry_out(
            &folder,
            options.threads,
            &options.output,
            |observer| match robot {
                None => optimise(&folder, &plan, observer),
                Some((z, controller)) => {
                    let codesign = CoDesign::new(&plan.scene)?;
                    let progress = codesign.begin_with(plan.seed, z, controller)?;
                    optimise_with(&folder, &plan, codesign, progress, observer)
                }
            },
        )
        .map_err(|error| pointed(error, &from))
    }

    /// Where the scene is read from, and what it is called.
    fn sources(&self) -> [String; 2] {
        if let Some(scene) = &self.scene {
            return [scene.clone(), name_of(scene)];
        }
        let beside = self
            .from
            .as_deref()
            .map(|from| design_of(from).with_file_name(SCENE));
        match beside.filter(|scene| scene.exists()) {
            None => [BUILTIN[0].name; 2].map(String::from),
            Some(scene) => {
                let summary = Summary::read(scene.parent().unwrap_or(Path::new("")));
                let scene = scene.display().to_string();
                let name = summary.map_or_else(|_| name_of(&scene), |summary| summary.scene);
                [scene, name]
            }
        }
    }

    /// What the run's folder is called where none is named: the run that goes on from another after
    /// that one.
    fn folder_name(&self, plan: &RunPlan) -> String {
        let before = self.from.as_deref().map(design_of);
        let folder = before.as_deref().and_then(Path::parent);
        let name = folder.and_then(|folder| match folder.file_name() {
            Some(name) => Some(name.to_owned()),
            // The folder that the user is in, and that above, have a name as well.
            None => Some(
                Path::new(".")
                    .join(folder)
                    .canonicalize()
                    .ok()?
                    .file_name()?
                    .to_owned(),
            ),
        });
        match name {
            Some(name) if self.scene.is_none() => format!("{}-on", name.to_string_lossy()),
            _ => format!("{}-{}", plan.name, plan.seed),
        }
    }
}

/// Shows an unstable time step where the scene sets it.
fn pointed(mut error: Error, scene: &str) -> Error {
    if let Error::UnstableStep { remedy, .. } = &mut error {
        remedy.push_str(" or say --allow-unstable");
    }
    let Some(remedy) = error.remedy() else {
        return error;
    };
    let message = error.without_remedy();
    fault(scene, &[""; 0], "physics.dt", &message, &remedy).unwrap_or(error)
}
