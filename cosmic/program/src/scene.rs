//! `cosmic scene`.

use crate::arguments::{Output, Settings};
use crate::cost::{Cost, announce};
use crate::output::{note, print, print_as, print_json};
use clap::{Args, Subcommand};
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic::numbers::shortened;
use cosmic::scene::{Builtin, Finding, Scene, Setting};
use cosmic::search::Review;
use serde_json::json;

/// The seed of the robot that `scene check` examines. It is also the default seed of `optimize`.
const SEED: u64 = 0;

/// List, show and check scenes
#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the built-in scenes, name first
    List {
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
    /// Print a complete scene, with all keys and comments
    Show {
        /// A built-in scene or a TOML file
        #[arg(value_name = "NAME")]
        scene: String,
        #[command(flatten)]
        settings: Settings,
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
    /// Check a scene, and describe its robot, its world and its cost
    ///
    /// Reports errors with line, column and the allowed values (exit code 2), including errors that only `optimize`
    /// would report. Warns about settings that are probably a mistake or have no effect.
    Check {
        /// A built-in scene or a TOML file
        #[arg(value_name = "SCENE")]
        scene: String,
        #[command(flatten)]
        settings: Settings,
        #[command(flatten)]
        output: Output,
    },
    /// Print the scene `earth` as a template for your own scenes
    ///
    /// `earth` also supplies the keys that are missing in a scene file, unless the file names another `base`.
    Default {
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        match &self.action {
            Action::List { json } => list(registry, *json),
            Action::Show {
                scene,
                settings,
                json,
            } => show(&settings.load(scene, registry)?, *json),
            Action::Check {
                scene,
                settings,
                output,
            } => check(scene, settings, output, registry),
            Action::Default { json } => show(&Scene::default(), *json),
        }
    }
}

fn check(name: &str, settings: &Settings, output: &Output, registry: &Registry) -> Result<()> {
    let scene = settings.load(name, registry)?;
    announce(&scene, output.quiet);
    let review = Review::new(&scene, SEED)?;
    if output.json {
        let rule = |s: Setting| json!({ "key": s.key, "value": s.value, "rule": s.auto });
        let following: Vec<_> = scene.following().into_iter().map(rule).collect();
        print_json(&json!({
            "ok": review.refusals.is_empty(),
            "departures": scene.departures(),
            "following": following,
            "robot": scene.describe_robot(),
            "world": scene.describe_world(),
            "refusals": review.refusals,
            "warnings": review.warnings,
        }))?;
    }
    if review.refusals.is_empty() && !output.json {
        print(&description(name, &scene)?)?;
    }
    // Warnings are results of this command; the JSON holds them too.
    if !(output.quiet && output.json) {
        for warning in &review.warnings {
            note(&format!("warning: {warning}"));
        }
    }
    match review.refusals.first() {
        Some(refusal) => Err(refused(name, settings, refusal, registry)),
        None => Ok(()),
    }
}

/// Describes a valid scene: the numbers that follow from others, the robot, the world, and the cost of a run. The rules
/// of the numbers that follow are in the output of `scene show`.
fn description(name: &str, scene: &Scene) -> Result<String> {
    let following = scene.following().into_iter();
    let lines = following.map(|s| format!("{} = {} (auto)\n", s.key, shortened(&s.value)));
    Ok(format!(
        "{}robot: {}\nworld: {}\ncost: {}\n{name}: ok\n",
        lines.collect::<String>(),
        scene.describe_robot(),
        scene.describe_world(),
        Cost::of(scene)?,
    ))
}

/// Makes the error for a scene that is refused. The error shows where the file or `--set` sets a key that causes the
/// refusal.
fn refused(name: &str, settings: &Settings, refusal: &Finding, registry: &Registry) -> Error {
    let mut keys = refusal.settings.iter().map(|setting| &*setting.key);
    let shown = |key| registry.fault(name, &settings.set, key, &refusal.says, &refusal.remedy);
    let unset = || Error::Usage(format!("{name}: {refusal}"));
    keys.find_map(shown).unwrap_or_else(unset)
}

fn list(registry: &Registry, as_json: bool) -> Result<()> {
    if as_json {
        let entry = |scene: Builtin| json!({ "name": scene.name, "about": scene.about() });
        return print_json(&registry.scenes().map(entry).collect::<Vec<_>>());
    }
    let widths = registry.scenes().map(|scene| scene.name.len());
    let width = widths.max().unwrap_or(0);
    let line = |scene: Builtin| format!("{:width$}  {}\n", scene.name, scene.about());
    print(&registry.scenes().map(line).collect::<String>())
}

fn show(scene: &Scene, json: bool) -> Result<()> {
    print_as(json, scene, &scene.to_toml())
}
