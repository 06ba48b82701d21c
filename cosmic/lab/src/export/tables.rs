//! The tables `bars.csv` and `nodes.csv`, in SI units. Numbers have nine decimals: lengths are exact to a nanometre,
//! masses to a microgram, forces to a nanonewton.

use super::member::{Member, nodes_of, place};
use crate::report::{RobotFiles, RunFiles, loads};
use crate::table::{Cell, Table};
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::scene::{ActuatorPart, Named, PartsSettings, SkeletonPart};
use cosmic::simulator::BarLoad;

/// The number of decimals in all tables.
const DECIMALS: usize = 9;

/// Returns the table of bars, with one row for each bar.
pub(super) fn bars(run: &RunFiles, members: &[Member]) -> Result<Table> {
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
    let mass = |m: &Member| m.material.of(&materials.of_length(m.length).density) * m.length;
    let table = Table::of("", "", members)
        .column("edge", "number of the edge in design.json", |m| m.edge)
        .column("from", "node at the first end", |m| m.nodes[0])
        .column("to", "node at the second end", |m| m.nodes[1])
        .columns(
            ["from_x", "from_y"],
            "position of the first end, m",
            |m, k| m.axis.from.array()[k],
        )
        .columns(["to_x", "to_y"], "position of the second end, m", |m, k| {
            m.axis.to.array()[k]
        })
        .column("rest_length", "length of the unstrained bar, m", |m| {
            m.length
        })
        .column("material", "skeleton or actuator", Member::made_of)
        .column(
            "part",
            "tube, rod, strut or device; empty for a bar of plain numbers",
            |m| part(m, &materials.parts),
        )
        .columns(
            ["outer", "inner"],
            "diameters of a tube, diameter of a rod, or width of a strut, m",
            |m, k| section(m, &materials.parts)[k],
        )
        .column(
            "stroke",
            "largest lengthening or shortening from the rest length, m",
            |m| stroke(m, &materials.max_strain),
        )
        .column("stiffness", "N/m", stiffness)
        .column("mass", "kg", mass)
        .column("peak_tension", "N", |m| load(m, |bar| bar.tension))
        .column("peak_compression", "N", |m| load(m, |bar| bar.compression))
        .column(
            "peak_force",
            "the larger of peak tension and peak compression, N",
            |m| load(m, |bar| bar.force.peak),
        )
        .column(
            "peak_strain",
            "largest change of length divided by the rest length",
            |m| load(m, |bar| bar.strain.peak),
        )
        .column(
            "euler_safety",
            "force under which the bar buckles, divided by peak compression; empty if not known",
            safety,
        );
    Ok(table.rounded(DECIMALS).done())
}

/// Returns the table of nodes, with one row for each node at which a bar ends.
pub(super) fn nodes(robot: &RobotFiles, members: &[Member]) -> Table {
    let nodes: Vec<usize> = nodes_of(members).into_iter().collect();
    let bars = |node: usize| members.iter().filter(|m| m.nodes.contains(&node)).count();
    let physics = &robot.scene.physics;
    let payload = |node: usize| -> f64 {
        let here = robot.lattice.payload.iter().filter(|p| p.node == node);
        here.fold(0.0, |sum, p| sum + p.mass.unwrap_or(physics.payload_mass))
    };
    let truss = robot.scene.lattice.file.truss();
    let given = "number of the node in the truss file that the user wrote, from 0";
    Table::of("", "", &nodes)
        .column("node", "number of the node", |node| *node)
        .columns(
            ["x", "y"],
            "position along and above the ground, m",
            |node, k| place(robot, *node)[k],
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

/// Returns the name of the part that a bar is.
fn part(member: &Member, parts: &PartsSettings) -> Cell {
    let name = match member.material {
        Material::Actuator if parts.actuator == ActuatorPart::Numbers => None,
        Material::Actuator => Some(parts.actuator.name()),
        _ if parts.skeleton == SkeletonPart::Numbers => None,
        _ => Some(parts.skeleton.name()),
    };
    name.into()
}

/// Returns the outer and the inner size of a bar's section, as far as it has them.
fn section(member: &Member, parts: &PartsSettings) -> [Option<f64>; 2] {
    let (outer, inner) = (Some(parts.outer), Some(parts.inner));
    match (member.material, parts.skeleton) {
        (Material::Actuator, _) | (_, SkeletonPart::Numbers) => [None, None],
        (_, SkeletonPart::Tube) => [outer, inner],
        (_, SkeletonPart::Rod | SkeletonPart::Strut) => [outer, None],
    }
}

fn stroke(member: &Member, max_strain: &[f64; 3]) -> f64 {
    match member.material {
        Material::Actuator => member.material.of(max_strain) * member.length,
        Material::Void | Material::Skeleton => 0.0,
    }
}
