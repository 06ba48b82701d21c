//! The tables `bars.csv` and `nodes.csv`, in SI units. Numbers have nine decimals: lengths are exact to a nanometre,
//! masses to a microgram, forces to a nanonewton.

use super::layers::joints;
use super::member::{MM, Member, place};
use super::pattern::Pattern;
use super::sizes::Sizes;
use crate::report::{RobotFiles, RunFiles, loads};
use crate::table::{Cell, Column, Table};
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::simulator::BarLoad;
use std::f64::consts::PI;

/// The number of decimals in all tables.
const DECIMALS: usize = 9;

/// Returns the table of bars, with one row for each bar.
pub(super) fn bars(
    run: &RunFiles,
    members: &[Member],
    pattern: Option<&Pattern>,
    sizes: &Sizes,
) -> Result<Table> {
    let materials = &run.robot.scene.materials;
    // The forces depend on all laws of the scene. If this program lacks one, it leaves out only the forces.
    let loads = match run.robot.lacks() {
        [] => Some(loads(run)?),
        _ => None,
    };
    let load = |m: &Member, of: fn(&BarLoad) -> f64| loads.as_ref().map(|loads| of(&loads[m.edge]));
    let of_edge = |m: &Member| materials.of_edge(&run.robot.lattice, m.edge);
    let stiffness = |m: &Member| m.material.of(&of_edge(m).stiffness);
    let safety = |m: &Member| {
        let bar = &loads.as_ref()?[m.edge];
        bar.euler_safety(materials, m.material, m.length)
    };
    let layer = |k: usize| Cell::from(pattern.map(|p| p.stack.of_member[k] as f64 + 1.0));
    let numbered: Vec<(usize, &Member)> = members.iter().enumerate().collect();
    let strip = |m: &Member| sizes.width * m.axis.length() + 0.25 * PI * sizes.width.powi(2);
    let volume = |m: &Member| (strip(m) - 0.5 * PI * sizes.hole.powi(2)) * sizes.thickness;
    let mass = |m: &Member| m.material.of(&materials.of_length(m.length).density) * m.length;
    let table = Table::of("", "", &numbered)
        .column("edge", "number of the edge in design.json", |(_, m)| m.edge)
        .column("from", "node at the first end", |(_, m)| m.nodes[0])
        .column("to", "node at the second end", |(_, m)| m.nodes[1])
        .columns(
            ["from_x", "from_y"],
            "position of the first end, m",
            |(_, m), k| (m.axis.from / MM).array()[k],
        )
        .columns(
            ["to_x", "to_y"],
            "position of the second end, m",
            |(_, m), k| (m.axis.to / MM).array()[k],
        )
        .column(
            "rest_length",
            "length of the unstrained bar, m",
            |(_, m)| m.length,
        )
        .column("material", "skeleton or actuator", |(_, m)| m.made_of())
        .column(
            "stroke",
            "largest lengthening or shortening from the rest length, m",
            |(_, m)| stroke(m, &materials.max_strain),
        )
        .column("stiffness", "N/m", |(_, m)| stiffness(m))
        .column("mass", "kg", |(_, m)| mass(m))
        .column("peak_tension", "N", |(_, m)| load(m, |bar| bar.tension))
        .column("peak_compression", "N", |(_, m)| {
            load(m, |bar| bar.compression)
        })
        .column(
            "peak_force",
            "the larger of peak tension and peak compression, N",
            |(_, m)| load(m, |bar| bar.force.peak),
        )
        .column(
            "peak_strain",
            "largest change of length divided by the rest length",
            |(_, m)| load(m, |bar| bar.strain.peak),
        )
        .column(
            "euler_safety",
            "force under which the bar buckles, divided by peak compression; empty if not known",
            |(_, m)| safety(m),
        )
        .add(
            whole("layer", "layer of the flat pattern, counted from 1"),
            |(k, _)| layer(*k),
        )
        .column(
            "plate_density",
            "density of the plate for which the strip has the mass of the bar, kg/m3",
            |(_, m)| mass(m) / (volume(m) / MM.powi(3)),
        );
    Ok(table.rounded(DECIMALS).done())
}

/// Returns the table of nodes, with one row for each node at which a bar ends.
pub(super) fn nodes(
    robot: &RobotFiles,
    members: &[Member],
    pattern: Option<&Pattern>,
    sizes: &Sizes,
) -> Table {
    let nodes: Vec<usize> = joints(members).into_keys().collect();
    let bars = |node: usize| members.iter().filter(|m| m.nodes.contains(&node)).count();
    let physics = &robot.scene.physics;
    let payload = |node: usize| -> f64 {
        let here = robot.lattice.payload.iter().filter(|p| p.node == node);
        here.fold(0.0, |sum, p| sum + p.mass.unwrap_or(physics.payload_mass))
    };
    let span = |node: usize| pattern.map(|pattern| &pattern.stack.at_node[&node]);
    let truss = robot.scene.lattice.file.truss();
    let given = "number of the node in the truss file that the user wrote, from 0";
    let number = |layer: Option<usize>| Cell::from(layer.map(|layer| layer as f64 + 1.0));
    Table::of("", "", &nodes)
        .column("node", "number of the node", |node| *node)
        .columns(
            ["x", "y"],
            "position along and above the ground, m",
            |node, k| place(robot, *node)[k] / MM,
        )
        .column("bars", "number of bars that end at the node", |node| {
            bars(*node)
        })
        .column("node_mass", "mass of the node itself, kg", |_| {
            physics.node_mass
        })
        .column("payload", "extra mass, kg", |node| payload(*node))
        .add(whole("lowest_layer", "lowest layer of its bars"), |node| {
            number(span(*node).map(|span| *span.start()))
        })
        .add(
            whole("highest_layer", "highest layer of its bars"),
            |node| number(span(*node).map(|span| *span.end())),
        )
        .column(
            "pin",
            "length of the pin, from the lowest of these layers to the highest, m",
            |node| span(*node).map(|s| (s.end() - s.start() + 1) as f64 * sizes.thickness / MM),
        )
        .column("given_node", given, |node| match truss {
            Some(truss) => truss.given_number(*node),
            None => *node,
        })
        .rounded(DECIMALS)
        .done()
}

/// Returns a column of whole numbers. A missing number is shown as `-`.
fn whole(name: &str, says: &str) -> Column {
    Column::new(name, says).decimals(0, "-")
}

fn stroke(member: &Member, max_strain: &[f64; 3]) -> f64 {
    if member.material == Material::Actuator {
        member.material.of(max_strain) * member.length
    } else {
        0.0
    }
}
