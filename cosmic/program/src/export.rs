//! `cosmic export`.

use crate::arguments::{Output, Settings, number, whole};
use crate::output::{answer_written, complain, note};
use crate::source::{Source, design_of};
use clap::Args;
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic_lab::export::mujoco::{self, MOST_FRICTION, MujocoSettings};
use cosmic_lab::export::{write_drawing, write_tables};
use cosmic_lab::report::RunFiles;
use std::path::{Path, PathBuf};

/// Export a robot: a model for MuJoCo, tables of its bars and nodes, and a drawing to scale
///
/// Without --mujoco, --csv and --svg, writes all files that the robot can have. If one kind cannot be made, the others are
/// still written. The drawing is in millimetres, tables are in SI units. docs/files.md describes the files. The Python module
/// cosmic.workshop makes DXF and STL files from the tables.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The folder of a finished run; with `--mujoco` also a design.json, a scene or a reference case
    #[arg(value_name = "RUN")]
    run: String,
    /// Write a model for the simulator MuJoCo, its controller, and a Python program that runs them
    #[arg(long)]
    mujoco: bool,
    /// Write tables: bars.csv, nodes.csv, parts.csv (what to buy and to saw) and drive.csv (set points of the actuators)
    #[arg(long)]
    csv: bool,
    /// Write drawing.svg: the robot at rest, to scale, with the numbers of nodes and bars
    #[arg(long)]
    svg: bool,
    /// Folder for the files [default: `export` beside design.json]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Friction in MuJoCo, at most 5 [default: the scene's coefficient, limited to 5]
    #[arg(long, value_name = "MU", value_parser = friction, allow_negative_numbers = true)]
    friction: Option<f64>,
    /// Mechanical steps per step of the controller in MuJoCo, at least as many as in the scene
    #[arg(long, value_name = "N", default_value_t = MujocoSettings::default().substeps, value_parser = whole(1..=64_usize), allow_negative_numbers = true)]
    substeps: usize,
    /// Hold skeleton bars at their length in MuJoCo, by equality constraints; robots with implicit steps need it
    #[arg(long)]
    rigid: bool,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    output: Output,
}

/// Parses a coefficient of friction for MuJoCo.
fn friction(text: &str) -> std::result::Result<f64, String> {
    let expected = format!("expected a number above 0, at most {MOST_FRICTION}");
    number(text, |x| 0.0 < x && x <= MOST_FRICTION, expected)
}

/// The files that an option writes: their paths, or the reason why there are none.
type Made = (&'static str, Result<Vec<PathBuf>>);

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let all = !(self.mujoco || self.csv || self.svg);
        let folder = self.out.clone();
        let folder =
            folder.unwrap_or_else(|| design_of(Path::new(&self.run)).with_file_name("export"));
        let mut made = match self.csv || self.svg || all {
            true => self.of_run(&folder, all, registry)?,
            false => Vec::new(),
        };
        if self.mujoco || all {
            made.push(("--mujoco", self.for_mujoco(&folder, registry)));
        }
        let written = made.iter().filter_map(|(_, made)| made.as_ref().ok());
        let written: Vec<&PathBuf> = written.flatten().collect();
        let has_written = !written.is_empty();
        if has_written {
            answer_written(&self.output, &written)?;
        }
        judge(all, has_written, made)
    }

    fn for_mujoco(&self, folder: &Path, registry: &Registry) -> Result<Vec<PathBuf>> {
        let case = Source::read(&self.run, &self.settings, registry)?.case;
        let settings = MujocoSettings {
            friction: self.friction,
            substeps: self.substeps,
            rigid: self.rigid,
        };
        mujoco::write(&case, &settings, folder)
    }

    /// Writes the tables and the drawing of a finished run, as far as they are asked for.
    fn of_run(&self, folder: &Path, all: bool, registry: &Registry) -> Result<Vec<Made>> {
        if !self.settings.set.is_empty() {
            return Err(Error::Usage(
                "--set works only with --mujoco alone: tables and drawing describe the finished run"
                    .into(),
            ));
        }
        let run = &RunFiles::read(Path::new(&self.run), registry)?;
        if run.robot.design.design().layout().is_none() {
            note(
                "warning: the design is undecided; the files give every edge its largest material, so their robot \
                 differs from the robot of the trajectory",
            );
        }
        let mut made = Vec::new();
        if self.csv || all {
            made.push(("--csv", write_tables(run, folder)));
        }
        if self.svg || all {
            made.push(("--svg", write_drawing(run, folder)));
        }
        Ok(made)
    }
}

/// Returns an error if files that were asked for could not be written. If several options failed, prints all errors but
/// the last and returns the last; options that failed for one reason have one error. If no kind of files was named and
/// the robot cannot have one kind, warns instead.
fn judge(all: bool, has_written: bool, made: Vec<Made>) -> Result<()> {
    let is_alone = made.len() == 1;
    let mut failed: Vec<(Vec<&str>, Error)> = Vec::new();
    for (option, made) in made {
        match made {
            Ok(_) => {}
            Err(Error::Usage(says)) if all && has_written => {
                note(&format!("warning: {option} was left out: {says}"));
            }
            Err(error) => {
                let says = error.to_string();
                let mut known = failed.iter_mut();
                match known.find(|(_, known)| known.to_string() == says) {
                    Some((options, _)) => options.push(option),
                    None => failed.push((vec![option], error)),
                }
            }
        }
    }
    let named = |(options, error): (Vec<&str>, Error)| match error {
        Error::Usage(says) if !is_alone => {
            let options = options.join(", ");
            Error::Usage(format!("{options}: {says} (its files were not written)"))
        }
        error => error,
    };
    let mut failed: Vec<Error> = failed.into_iter().map(named).collect();
    let Some(last) = failed.pop() else {
        return Ok(());
    };
    failed.iter().for_each(complain);
    Err(last)
}
