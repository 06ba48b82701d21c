//! `cosmic export`.

use crate::arguments::Output;
use crate::output::{answer_written, note};
use clap::{ArgGroup, Args};
use cosmic::error::Result;
use cosmic_lab::export;
use cosmic_lab::report::RunFiles;
use std::path::PathBuf;

/// Write the robot of a finished run for the workshop: tables, a flat pattern, a solid
///
/// Drawings and solids are in millimetres, tables in SI units. docs/files.md says what is in the files.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("kind").required(true).multiple(true)))]
pub(super) struct Arguments {
    /// The run's folder
    #[arg(value_name = "RUN")]
    run: PathBuf,
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
    /// Where to write; by default the folder export in the run's
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    sizes: Sizes,
    #[command(flatten)]
    output: Output,
}

/// Sizes for the workshop.
#[derive(Debug, Args)]
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
        let run = &RunFiles::read(&self.run)?;
        if !run.robot.design.is_snapped() {
            note(
                "warning: the design is not decided; each edge is taken to be what it is most of, \
                 and so it is not the robot of the trajectory",
            );
        }
        let folder = (self.out.clone()).unwrap_or_else(|| self.run.join("export"));
        let sizes = &self.sizes.chosen();
        // Everything is made before anything is written.
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
        answer_written(&self.output, &export::write(&folder, &files)?)
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
