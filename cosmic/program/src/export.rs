//! `cosmic export`.

use crate::arguments::{Output, Settings};
use crate::mujoco::MujocoOptions;
use crate::output::{answer_written, note};
use crate::source::{Source, design_of};
use clap::{ArgGroup, Args};
use cosmic::error::{Error, Result};
use cosmic_lab::export::{self, ExportFile, mujoco};
use cosmic_lab::report::RunFiles;
use std::path::{Path, PathBuf};

/// Write a robot for other programs: a model for MuJoCo, or files for the workshop
///
/// At least one kind has to be named. Drawings and solids are in millimetres, tables in SI units. docs/files.md says what is in the files.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("kind").required(true).multiple(true)))]
pub(super) struct Arguments {
    /// The folder of a finished run; for `--mujoco` also a design.json, a scene or a reference case
    #[arg(value_name = "RUN")]
    run: String,
    /// A model for the simulator MuJoCo, its controller, and a program in Python that walks it
    #[arg(long, group = "kind")]
    mujoco: bool,
    /// bars.csv and nodes.csv: ends, rest lengths, materials, strokes, peak forces, masses
    #[arg(long, group = "kind")]
    csv: bool,
    /// pattern.svg: the bars as strips of plate with holes, layer by layer, to scale
    #[arg(long, group = "kind")]
    svg: bool,
    /// pattern.dxf: the same pattern
    #[arg(long, group = "kind")]
    dxf: bool,
    /// robot.stl, skeleton.stl and actuators.stl: struts and joints; solid.csv: what they weigh
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
    /// Width of a bar of the pattern, mm
    #[arg(long, value_name = "MM", default_value_t = 12.0, value_parser = size, allow_negative_numbers = true)]
    width: f64,
    /// Diameter of the pattern's holes at the nodes, mm
    #[arg(long, value_name = "MM", default_value_t = 4.0, value_parser = size, allow_negative_numbers = true)]
    hole: f64,
    /// Thickness of the plate that the pattern is cut from, mm
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = size, allow_negative_numbers = true)]
    thickness: f64,
    /// Least distance of bars in one layer of the pattern or one plane of the solid, mm
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = size, allow_negative_numbers = true)]
    gap: f64,
    /// Radius of the solid's skeleton struts, mm; that of actuators follows from the line densities
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = size, allow_negative_numbers = true)]
    radius: f64,
}

/// Reads a size in millimetres, from a micrometre to a kilometre.
fn size(text: &str) -> std::result::Result<f64, String> {
    match text.parse() {
        Ok(x) if (1e-3..=1e6).contains(&x) => Ok(x),
        _ => Err("expected a number of millimetres from 0.001 to 1000000".to_owned()),
    }
}

impl Arguments {
    pub(super) fn run(&self) -> Result<()> {
        let folder = self.out.clone();
        let folder =
            folder.unwrap_or_else(|| design_of(Path::new(&self.run)).with_file_name("export"));
        let mut written = Vec::new();
        if self.csv || self.svg || self.dxf || self.stl {
            written.extend(export::write(&folder, &self.for_workshop()?)?);
        }
        if self.mujoco {
            let case = Source::read(&self.run, &self.settings)?.case;
            written.extend(mujoco::write(&case, &self.of_mujoco.settings(), &folder)?);
        }
        answer_written(&self.output, &written)
    }

    /// The files for the workshop, all of them made before any is written.
    fn for_workshop(&self) -> Result<Vec<ExportFile>> {
        if !self.settings.set.is_empty() {
            return Err(Error::Usage(
                "--set is for --mujoco: files for the workshop are of the run as it is".into(),
            ));
        }
        let run = &RunFiles::read(Path::new(&self.run))?;
        if !run.robot.design.is_snapped() {
            note(
                "warning: the design is not decided; each edge is taken to be what it is most of, \
                 and so it is not the robot of the trajectory",
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
        let mut files = Vec::new();
        if self.csv {
            files.extend(export::tables(run, sizes)?);
        }
        if self.svg {
            files.extend(export::pattern_svg(run, sizes)?);
        }
        if self.dxf {
            files.extend(export::pattern_dxf(run, sizes)?);
        }
        if self.stl {
            files.extend(export::solid(run, sizes)?);
        }
        Ok(files)
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
