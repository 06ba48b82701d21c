//! `cosmic scene`.

use crate::arguments::Output;
use crate::output::{print, print_json};
use clap::{Args, Subcommand};
use cosmic::error::Result;
use cosmic::scene::{BUILTIN, Scene};
use serde_json::json;
use std::path::PathBuf;

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
    /// Print a scene complete, with every key and what it means
    Show {
        /// A built-in scene or a TOML file
        #[arg(value_name = "NAME")]
        scene: String,
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
    /// Check a scene file: exit 2 with line, column and what is allowed where it is wrong
    Check {
        /// A TOML file
        #[arg(value_name = "FILE")]
        file: PathBuf,
        #[command(flatten)]
        output: Output,
    },
    /// Print the default scene, complete and commented: a template for one's own
    Default {
        /// Write JSON
        #[arg(long)]
        json: bool,
    },
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        match &self.action {
            Action::List { json } => list(*json),
            Action::Show { scene, json } => show(&Scene::load(scene)?, *json),
            Action::Check { file, output } => {
                let scene = Scene::read(file)?;
                if output.json {
                    print_json(&json!({ "ok": true, "departures": scene.departures() }))
                } else if output.quiet {
                    Ok(())
                } else {
                    print(&format!("{}: ok\n", file.display()))
                }
            }
            Action::Default { json } => show(&Scene::default(), *json),
        }
    }
}

fn list(as_json: bool) -> Result<()> {
    if as_json {
        let entry = |name, about| json!({ "name": name, "about": about });
        let entries: Vec<_> = BUILTIN
            .iter()
            .map(|scene| entry(scene.name, scene.about()))
            .collect();
        return print_json(&entries);
    }
    let width = BUILTIN
        .iter()
        .map(|scene| scene.name.len())
        .max()
        .unwrap_or(0);
    let line = |name, about| format!("{name:width$}  {about}\n");
    print(
        &BUILTIN
            .iter()
            .map(|scene| line(scene.name, scene.about()))
            .collect::<String>(),
    )
}

fn show(scene: &Scene, json: bool) -> Result<()> {
    if json {
        print_json(scene)
    } else {
        print(&scene.to_toml())
    }
}
