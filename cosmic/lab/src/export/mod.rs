//! Writes files with which other programs use a finished robot: a model for MuJoCo, two tables and a drawing to scale.
//!
//! Tables and drawing show the bars at rest, without void edges, in the frame of the ground: positions are measured along
//! and above it from the lattice's lower left corner.

mod member;
mod tables;
mod drawing;
mod controller;
pub mod mujoco;

use crate::files::write_texts;
use crate::report::RunFiles;
use cosmic::error::Result;
use cosmic::record::files::make_folder;
use member::members;
use std::path::{Path, PathBuf};

/// Writes `bars.csv` and `nodes.csv`, the bars and nodes with peak forces and masses, into a folder. Returns the paths.
///
/// # Errors
/// [`Error::Usage`](cosmic::Error::Usage) for a robot without solid bars; [`Error::Write`](cosmic::Error::Write).
pub fn write_tables(run: &RunFiles, folder: &Path) -> Result<Vec<PathBuf>> {
    let members = members(&run.robot)?;
    let bars = tables::bars(run, &members)?.to_csv();
    let nodes = tables::nodes(&run.robot, &members).to_csv();
    make_folder(folder)?;
    write_texts(folder, [("bars.csv", bars), ("nodes.csv", nodes)])
}

/// Writes `drawing.svg`, the robot to scale with the numbers of its nodes and bars, into a folder. Returns the path.
///
/// # Errors
/// The errors of [`write_tables`].
pub fn write_drawing(run: &RunFiles, folder: &Path) -> Result<Vec<PathBuf>> {
    let drawing = drawing::draw(&run.robot, &members(&run.robot)?);
    make_folder(folder)?;
    write_texts(folder, [("drawing.svg", drawing)])
}
