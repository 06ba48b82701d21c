//! Writes files with which other programs use a finished robot: a model for MuJoCo; and, for a workshop, tables, a flat
//! pattern and a solid.
//!
//! Files for the workshop show the bars at rest, without void edges. Positions are measured along and above the ground
//! from the lattice's lower left corner. Drawings and solids are in millimetres, tables in SI units.

mod sizes;
pub mod member;
pub mod layers;
mod pattern;
mod csv;
mod svg;
mod dxf;
pub mod stl;
pub mod joint;
mod frame;
mod controller;
pub mod mujoco;

use crate::report::RunFiles;
use cosmic::error::Result;
use cosmic::record::files::{make_folder, write_atomic};
use frame::Frame;
use member::members;
use pattern::Pattern;
pub use sizes::Sizes;
use std::path::{Path, PathBuf};

/// A file that an export writes: its name and its content.
pub struct ExportFile {
    name: &'static str,
    bytes: Vec<u8>,
}

impl ExportFile {
    fn new(name: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        let bytes = bytes.into();
        Self { name, bytes }
    }
}

/// Returns `bars.csv` and `nodes.csv`: the bars and nodes, with peak forces and masses.
///
/// # Errors
/// [`Error::Usage`](cosmic::Error::Usage) for a robot without solid bars.
pub fn tables(run: &RunFiles, sizes: &Sizes) -> Result<Vec<ExportFile>> {
    let members = members(&run.robot)?;
    // If the robot has no flat pattern, the tables are still useful: the workshop may make the robot in another way.
    let pattern = Pattern::new(&members, sizes).ok();
    let bars = csv::bars(run, &members, pattern.as_ref(), sizes)?;
    let nodes = csv::nodes(&run.robot, &members, pattern.as_ref(), sizes);
    Ok(vec![
        ExportFile::new("bars.csv", bars.to_csv()),
        ExportFile::new("nodes.csv", nodes.to_csv()),
    ])
}

/// Returns `pattern.svg`: the flat pattern.
///
/// # Errors
/// [`Error::Usage`](cosmic::Error::Usage) for sizes that do not fit the robot, or a robot that cannot be stacked from
/// plates.
pub fn pattern_svg(run: &RunFiles, sizes: &Sizes) -> Result<Vec<ExportFile>> {
    let pattern = Pattern::new(&members(&run.robot)?, sizes)?;
    Ok(vec![ExportFile::new("pattern.svg", svg::draw(&pattern))])
}

/// Returns `pattern.dxf`: the pattern of [`pattern_svg`] as DXF.
///
/// # Errors
/// The errors of [`pattern_svg`].
pub fn pattern_dxf(run: &RunFiles, sizes: &Sizes) -> Result<Vec<ExportFile>> {
    let pattern = Pattern::new(&members(&run.robot)?, sizes)?;
    Ok(vec![ExportFile::new("pattern.dxf", dxf::draw(&pattern))])
}

/// Returns four files: `robot.stl`, the whole solid; `skeleton.stl` and `actuators.stl`, the struts and joints of one
/// material; and `solid.csv`, the volumes, densities and masses of these parts.
///
/// # Errors
/// [`Error::Usage`](cosmic::Error::Usage) for struts that are too thick for the robot.
pub fn solid(run: &RunFiles, sizes: &Sizes) -> Result<Vec<ExportFile>> {
    let frame = Frame::new(&run.robot, members(&run.robot)?, sizes)?;
    let solids = [
        ("robot.stl", frame.prisms(|_| true)),
        ("skeleton.stl", frame.prisms(|kind| !kind.is_actuator())),
        ("actuators.stl", frame.prisms(|kind| kind.is_actuator())),
    ];
    let file = |(name, prisms): (_, Vec<_>)| ExportFile::new(name, stl::binary(&prisms));
    let mut files: Vec<_> = solids.into_iter().map(file).collect();
    files.push(ExportFile::new("solid.csv", frame.table().to_csv()));
    Ok(files)
}

/// Writes files into a folder, which is created if necessary, and returns their paths.
///
/// # Errors
/// [`Error::Write`](cosmic::Error::Write).
pub fn write(folder: &Path, files: &[ExportFile]) -> Result<Vec<PathBuf>> {
    make_folder(folder)?;
    let write = |file: &ExportFile| {
        let path = folder.join(file.name);
        write_atomic(&path, |out| out.write_all(&file.bytes))?;
        Ok(path)
    };
    files.iter().map(write).collect()
}
