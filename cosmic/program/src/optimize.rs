//! `cosmic optimize`.

use crate::arguments::{Settings, Work, count, seed};
use crate::cost::{Cost, announce};
use crate::runs;
use crate::source::{design_of, name_of, robot};
use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::record::run::{SCENE, read_scene, read_summary};
use cosmic::record::{RunPlan, optimise, optimise_with};
use cosmic::scene::{Scene, UnstableStep};
use cosmic::search::CoDesign;
use std::ffi::{OsStr, OsString};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Design a robot and its controller together, with algorithm 1 of the paper
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A built-in scene or a TOML file [default: earth; with --from, the scene beside that design]
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    #[command(flatten)]
    settings: Settings,
    /// Try this many seeds, starting with --seed, and keep the best robot
    #[arg(long, value_name = "N", default_value = "1", value_parser = count, allow_negative_numbers = true)]
    starts: NonZeroUsize,
    /// Start with the robot in a run's folder or a design.json. If every edge already has one material, the run starts
    /// after the snap and only fine-tunes
    #[arg(long, value_name = "RUN", conflicts_with = "starts")]
    from: Option<PathBuf>,
    /// Fit the phases of the schedule into this many iterations, so that a short run ends with a finished robot; with
    /// --from and a finished robot, fine-tune it for so many iterations
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    iterations: Option<NonZeroUsize>,
    /// Continue even if the time step is unstable for the robot (like unstable_step = "warn" in the scene)
    #[arg(long)]
    allow_unstable: bool,
    /// Seed of the random generator
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = seed, allow_negative_numbers = true)]
    seed: u64,
    /// New or empty folder for the results [default: runs/SCENE-SEED; with --from NAME and no SCENE, runs/NAME-on]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    work: Work,
}

/// Returns the lines to print before a run: a description of the robot, of the world and of the cost, each in one line,
/// and warnings about settings that are probably a mistake.
fn introduction(plan: &RunPlan) -> Result<Vec<String>> {
    let robot = format!("robot: {}", plan.scene.describe_robot());
    let world = format!("world: {}", plan.scene.describe_world());
    let cost = format!("cost: {}", Cost::of_plan(plan)?);
    let warnings = plan.scene.warnings().into_iter();
    let warnings = warnings.map(|warning| format!("warning: {warning}"));
    let lines = [robot, world, cost].into_iter();
    Ok(lines.chain(warnings).collect())
}

/// The scene in which the robot is optimised, and its source.
struct Origin {
    scene: Scene,
    /// The scene's name. It appears in the summary and in the name of the run's folder.
    name: String,
    /// The name of a built-in scene, or the path of the scene's file; for messages.
    source: String,
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let mut origin = self.origin(registry)?;
        if self.allow_unstable {
            origin.scene.physics.unstable_step = UnstableStep::Warn;
        }
        let plan = RunPlan {
            name: origin.name,
            scene: origin.scene,
            seed: self.seed,
            starts: self.starts,
            iterations: None,
        };
        let from = self.from.as_deref();
        let robot = from.map(|from| robot(from, &plan.scene)).transpose()?;
        let plan = plan.fitted(self.iterations, robot.as_ref().map(|(design, _)| design))?;
        let default = || Path::new("runs").join(self.folder_name(&plan));
        let folder = self.out.clone().unwrap_or_else(default);
        announce(&plan.scene, self.work.output.quiet);
        let introduction = match self.work.output.quiet {
            true => Vec::new(),
            false => introduction(&plan)?,
        };
        runs::carry_out(
            &folder,
            registry,
            &self.work,
            introduction,
            |observer| match robot {
                None => optimise(&folder, &plan, observer),
                Some((design, controller)) => {
                    let codesign = CoDesign::new(&plan.scene)?;
                    let progress = codesign.begin_with(plan.seed, design, controller)?;
                    optimise_with(&folder, &plan, codesign, progress, observer)
                }
            },
        )
        .map_err(|error| self.with_place(error, &origin.source, registry))
    }

    /// Chooses the scene: the one given on the command line, otherwise the one beside the design of `--from`, otherwise
    /// the default scene.
    fn origin(&self, registry: &Registry) -> Result<Origin> {
        let beside = |from: &PathBuf| design_of(from).with_file_name(SCENE);
        let beside = self.from.as_ref().map(beside).filter(|file| file.exists());
        if let Some(file) = beside.filter(|_| self.scene.is_none()) {
            let folder = file.parent().unwrap_or(Path::new(""));
            let summary = read_summary(folder);
            return Ok(Origin {
                scene: read_scene(folder, registry)?.set(&self.settings.set)?,
                name: summary.map_or_else(|_| name_of(&file), |summary| summary.scene),
                source: file.display().to_string(),
            });
        }
        let default = registry.default_scene().name;
        let source = self.scene.as_deref().unwrap_or(default);
        Ok(Origin {
            scene: self.settings.load(source, registry)?,
            name: name_of(Path::new(source)),
            source: source.to_owned(),
        })
    }

    /// The default name of the run's folder. It consists of scene and seed. If `--from` is given without a scene, it is
    /// the name of the design's folder with `-on` at the end.
    fn folder_name(&self, plan: &RunPlan) -> OsString {
        let Some(mut name) = self.folder_before().filter(|_| self.scene.is_none()) else {
            return format!("{}-{}", plan.name, plan.seed).into();
        };
        name.push("-on");
        name
    }

    /// The name of the folder that contains the design of `--from`.
    fn folder_before(&self) -> Option<OsString> {
        let design = design_of(self.from.as_deref()?);
        let folder = design.parent()?;
        let name = |path: &Path| path.file_name().map(OsStr::to_owned);
        // The paths `.` and `..` have no name until they are resolved.
        name(folder).or_else(|| name(&Path::new(".").join(folder).canonicalize().ok()?))
    }

    /// Adds advice to an error about an unstable time step: the place in the scene that sets the step, and the option
    /// `--allow-unstable`. Other errors stay as they are.
    fn with_place(&self, mut error: Error, source: &str, registry: &Registry) -> Error {
        if let Error::UnstableStep { remedy, .. } = &mut error {
            remedy.push_str(" or add --allow-unstable");
        }
        let Some(remedy) = error.remedy() else {
            return error;
        };
        let message = error.without_remedy();
        let set = &self.settings.set;
        let fault = registry.fault(source, set, "physics.dt", &message, &remedy);
        fault.unwrap_or(error)
    }
}
