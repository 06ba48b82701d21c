//! `cosmic export`.

use crate::arguments::{Output, Settings, number};
use crate::mujoco::MujocoOptions;
use crate::output::{answer_written, complain, note};
use crate::source::{Source, design_of};
use clap::{ArgGroup, Args};
use cosmic::Registry;
use cosmic::error::{Error, Result};
use cosmic_lab::export::{self, ExportFile, mujoco};
use cosmic_lab::report::RunFiles;
use std::path::{Path, PathBuf};

/// Export a robot: a model for MuJoCo, or files for the workshop
///
/// Name at least one kind of file. If one kind cannot be made, the others are still written. Drawings and solids are in
/// millimetres, tables in SI units. docs/files.md describes the files.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("kind").required(true).multiple(true)))]
pub(super) struct Arguments {
    /// The folder of a finished run; with `--mujoco` also a design.json, a scene or a reference case
    #[arg(value_name = "RUN")]
    run: String,
    /// Write a model for the simulator MuJoCo, its controller, and a Python program that runs them
    #[arg(long, group = "kind")]
    mujoco: bool,
    /// Write bars.csv and nodes.csv: ends, rest lengths, materials, strokes, peak forces, masses
    #[arg(long, group = "kind")]
    csv: bool,
    /// Write pattern.svg: the bars as strips of plate with holes, layer by layer, to scale
    #[arg(long, group = "kind")]
    svg: bool,
    /// Write pattern.dxf: the same pattern
    #[arg(long, group = "kind")]
    dxf: bool,
    /// Write robot.stl, skeleton.stl and actuators.stl: struts and joints; and solid.csv with their masses
    #[arg(long, group = "kind")]
    stl: bool,
    /// Folder for the files [default: `export` beside design.json]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    of_mujoco: MujocoOptions,
    #[command(flatten)]
    sizes: Sizes,
}

/// Sizes for the workshop.
#[derive(Debug, Args)]
#[command(next_help_heading = "Sizes for the workshop")]
struct Sizes {
    /// Width of the bars of the pattern, mm
    #[arg(long, value_name = "MM", default_value_t = 12.0, value_parser = size, allow_negative_numbers = true)]
    width: f64,
    /// Diameter of the holes at the nodes of the pattern, mm
    #[arg(long, value_name = "MM", default_value_t = 4.0, value_parser = size, allow_negative_numbers = true)]
    hole: f64,
    /// Thickness of the plate for the pattern, mm
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = size, allow_negative_numbers = true)]
    thickness: f64,
    /// Minimum distance between bars in one layer of the pattern or one plane of the solid, mm
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = size, allow_negative_numbers = true)]
    gap: f64,
    /// Radius of the skeleton struts of the solid, mm; the radius of actuators follows from the line densities
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = size, allow_negative_numbers = true)]
    radius: f64,
}

/// Parses a size in millimetres, from a micrometre to a kilometre.
fn size(text: &str) -> std::result::Result<f64, String> {
    let expected = "expected a number of millimetres from 0.001 to 1000000";
    number(text, |x| (1e-3..=1e6).contains(&x), expected.to_owned())
}

impl Arguments {
    pub(super) fn run(&self, registry: &Registry) -> Result<()> {
        let folder = self.out.clone();
        let folder =
            folder.unwrap_or_else(|| design_of(Path::new(&self.run)).with_file_name("export"));
        let mut made = Made::default();
        if self.csv || self.svg || self.dxf || self.stl {
            let files = self.for_workshop(registry, &mut made.failed)?;
            if !files.is_empty() {
                made.written.extend(export::write(&folder, &files)?);
            }
        }
        if self.mujoco {
            match self.for_mujoco(&folder, registry) {
                Ok(written) => made.written.extend(written),
                Err(error) => made.failed.push(("--mujoco", error)),
            }
        }
        if !made.written.is_empty() {
            answer_written(&self.output, &made.written)?;
        }
        made.judge()
    }

    fn for_mujoco(&self, folder: &Path, registry: &Registry) -> Result<Vec<PathBuf>> {
        let case = Source::read(&self.run, &self.settings, registry)?.case;
        mujoco::write(&case, &self.of_mujoco.settings(), folder)
    }

    /// Writes the files for the workshop. If one kind of file cannot be made, its option and the error are added to
    /// `failed`.
    fn for_workshop(
        &self,
        registry: &Registry,
        failed: &mut Vec<(&'static str, Error)>,
    ) -> Result<Vec<ExportFile>> {
        if !self.settings.set.is_empty() {
            return Err(Error::Usage(
                "--set works only with --mujoco: files for the workshop describe the finished run"
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
        if let Some(says) = run
            .robot
            .left_out("the peak forces in bars.csv")
            .filter(|_| self.csv)
        {
            note(&format!("warning: {says}"));
        }
        let sizes = &self.sizes.chosen();
        type Make = fn(&RunFiles, &export::Sizes) -> Result<Vec<ExportFile>>;
        let kinds: [(_, _, Make); 4] = [
            ("--csv", self.csv, export::tables),
            ("--svg", self.svg, export::pattern_svg),
            ("--dxf", self.dxf, export::pattern_dxf),
            ("--stl", self.stl, export::solid),
        ];
        let mut files = Vec::new();
        for (option, _, make) in kinds.into_iter().filter(|(_, is_asked, _)| *is_asked) {
            match make(run, sizes) {
                Ok(made) => files.extend(made),
                Err(error) => failed.push((option, error)),
            }
        }
        Ok(files)
    }
}

/// The result of an export: the files that were written, and the options that failed.
#[derive(Default)]
struct Made {
    written: Vec<PathBuf>,
    /// The options whose files could not be written, each with its error.
    failed: Vec<(&'static str, Error)>,
}

impl Made {
    /// Returns an error if the files of an option could not be written. If several options failed, prints all errors
    /// but the last and returns the last.
    fn judge(self) -> Result<()> {
        let is_alone = self.written.is_empty() && self.failed.len() == 1;
        let named = |(option, error): (&str, Error)| match error {
            Error::Usage(says) if !is_alone => {
                Error::Usage(format!("{option}: {says} (its files were not written)"))
            }
            error => error,
        };
        let mut failed = self.failed.into_iter().map(named);
        let Some(last) = failed.next_back() else {
            return Ok(());
        };
        failed.for_each(|error| complain(&error));
        Err(last)
    }
}

impl Sizes {
    fn chosen(&self) -> export::Sizes {
        export::Sizes {
            width: self.width,
            hole: self.hole,
            gap: self.gap,
            thickness: self.thickness,
            radius: self.radius,
        }
    }
}
