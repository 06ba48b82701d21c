//! Writes files with which other programs use a finished robot: a model for MuJoCo, two tables and a drawing to scale.
//!
//! Tables and drawing show the bars at rest, without void edges, in the frame of the ground: positions are measured along
//! and above it, in space also across, from the lattice's lower left corner.

mod member;
mod shop;
mod drawing;
mod controller;
pub mod mujoco;

use crate::files::write_texts;
use crate::report::gait::Gait;
use crate::report::{RobotFiles, RunFiles};
use crate::table::Table;
use cosmic::error::{Error, Result};
use cosmic::record::files::make_folder;
use member::{DECIMALS, Member, axes, bars, members, nodes_of, place};
use shop::{parts, set_points};
use std::path::{Path, PathBuf};

/// Writes tables into a folder: `bars.csv` and `nodes.csv`, the bars and nodes with peak forces and masses; `parts.csv`, what
/// to buy and to saw; and `drive.csv`, the lengths of the actuators over a period, unless goals are given. Returns the paths.
///
/// # Errors
/// [`Error::Usage`] for a robot without solid bars; [`Error::Write`].
pub fn write_tables(run: &RunFiles, folder: &Path) -> Result<Vec<PathBuf>> {
    let (members, gait) = (some_members(&run.robot)?, Gait::new(run)?);
    let tables = [
        ("bars.csv", Some(bars(&run.robot, &members, &gait.loads))),
        ("nodes.csv", Some(nodes(&run.robot, &members))),
        ("parts.csv", Some(parts(run))),
        ("drive.csv", set_points(run, &gait)),
    ];
    make_folder(folder)?;
    let tables = tables.into_iter();
    write_texts(
        folder,
        tables.filter_map(|(name, table)| Some((name, table?.to_csv()))),
    )
}

/// Returns the bars of a robot. Fails if there are none.
fn some_members(robot: &RobotFiles) -> Result<Vec<Member>> {
    let members = members(robot);
    if members.is_empty() {
        return Err(Error::Usage(
            "cannot export: all edges of the robot are void, so there is nothing to export".into(),
        ));
    }
    Ok(members)
}

/// Writes `drawing.svg`, the robot to scale with the numbers of its nodes and bars, into a folder. Returns the path.
///
/// # Errors
/// The errors of [`write_tables`].
pub fn write_drawing(run: &RunFiles, folder: &Path) -> Result<Vec<PathBuf>> {
    let drawing = drawing::draw(&run.robot, &some_members(&run.robot)?);
    make_folder(folder)?;
    write_texts(folder, [("drawing.svg", drawing)])
}

/// Returns the table of nodes, with one row for each node at which a bar ends.
fn nodes(robot: &RobotFiles, members: &[Member]) -> Table {
    let nodes: Vec<usize> = nodes_of(members).into_iter().collect();
    let bars = |node: usize| members.iter().filter(|m| m.nodes.contains(&node)).count();
    let physics = &robot.scene.physics;
    let payload = |node: usize| -> f64 {
        let here = robot.lattice.payload.iter().filter(|p| p.node == node);
        here.fold(0.0, |sum, p| sum + physics.mass_of(p))
    };
    let truss = robot.scene.lattice.file.truss();
    let given = "number of the node in the truss file that the user wrote, from 0";
    Table::of("", "", &nodes)
        .column("node", "number of the node", |node| *node)
        .columns(
            axes(robot, ""),
            "position along and above the ground, in space along, across and above, m",
            |node, k| robot.lattice.dimension.list(place(robot, *node))[k],
        )
        .column("bars", "number of bars that end at the node", |node| {
            bars(*node)
        })
        .column("node_mass", "mass of the node itself, kg", |_| {
            physics.node_mass
        })
        .column("payload", "extra mass, kg", |node| payload(*node))
        .column("given_node", given, |node| match truss {
            Some(truss) => truss.given_number(*node),
            None => *node,
        })
        .rounded(DECIMALS)
        .done()
}
