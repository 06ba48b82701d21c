//! The bars of a robot, which are the solid edges of its layout, and the table of bars.
//!
//! Positions are those of the robot at rest in the frame of the ground: along and above it, in space also across, from the
//! lattice's lower left corner.

use crate::report::RobotFiles;
use crate::table::Table;
use cosmic::design::Material;
use cosmic::geometry::{Segment, Vector};
use cosmic::scene::{MaterialSettings, PartsSettings, SkeletonPart};
use cosmic::shop::{made_of, mass, part};
use cosmic::walk::BarLoad;
use std::collections::BTreeSet;

/// The number of decimals in CSV: lengths are exact to a nanometre, masses to a microgram, forces to a nanonewton.
pub(super) const DECIMALS: usize = 9;

/// A bar of a robot.
pub(super) struct Member {
    /// The index of its edge in the lattice.
    pub(super) edge: usize,
    /// The nodes at its ends.
    pub(super) nodes: [usize; 2],
    /// The line from the first node to the second, in metres.
    pub(super) axis: Segment,
    /// Skeleton or actuator.
    pub(super) material: Material,
    /// The rest length, in metres.
    pub(super) length: f64,
}

/// Returns the nodes at which bars end.
pub(super) fn nodes_of(members: &[Member]) -> BTreeSet<usize> {
    members.iter().flat_map(|member| member.nodes).collect()
}

/// Returns the position of a node in the frame of the ground, in metres.
pub(super) fn place(robot: &RobotFiles, node: usize) -> Vector<f64> {
    robot.lattice.places[node] * robot.lattice.spacing
}

/// Returns the names of the columns for the coordinates of a point: `x` and `y` for along and above, and in space `x`, `y`
/// and `z` for along, across and above. The names begin with `prefix`.
pub(super) fn axes(robot: &RobotFiles, prefix: &str) -> Vec<String> {
    let names = ["x", "y", "z"].into_iter();
    names
        .take(robot.lattice.dimension.count())
        .map(|name| format!("{prefix}{name}"))
        .collect()
}

/// Returns the bars of a robot.
pub(super) fn members(robot: &RobotFiles) -> Vec<Member> {
    let member = |edge: usize| {
        let nodes = robot.lattice.edges[edge];
        let [from, to] = nodes.map(|node| place(robot, node));
        Member {
            edge,
            nodes,
            axis: Segment::new(from, to),
            material: robot.design.materials[edge],
            length: robot.lattice.rest_length[edge],
        }
    };
    let solid = robot.edges_of(Material::is_solid).into_iter();
    solid.map(member).collect()
}

/// Returns the table of bars, with a row for each. `loads` has the loads of all edges.
pub(super) fn bars(robot: &RobotFiles, members: &[Member], loads: &[BarLoad]) -> Table {
    let (materials, dimension) = (&robot.scene.materials, robot.lattice.dimension);
    let stiffness = |m: &Member| {
        let bar = materials.of_edge(&robot.lattice, m.edge);
        m.material.of(&bar.stiffness)
    };
    let safety = |m: &Member| loads[m.edge].euler_safety(materials, m.material, m.length);
    let part_says = "tube, rod, strut or device; empty for a bar of plain numbers";
    let size_says = "diameters of a tube, diameter of a rod, or width of a strut, m";
    let stroke_says = "largest lengthening or shortening from the rest length, m";
    let euler_says = "skeleton: force under which the bar buckles, divided by peak compression";
    Table::of("", "", members)
        .column("edge", "number of the edge in design.json", |m| m.edge)
        .column("from", "node at the first end", |m| m.nodes[0])
        .column("to", "node at the second end", |m| m.nodes[1])
        .columns(axes(robot, "from_"), "place of the first end, m", |m, k| {
            dimension.list(m.axis.from)[k]
        })
        .columns(axes(robot, "to_"), "place of the second end, m", |m, k| {
            dimension.list(m.axis.to)[k]
        })
        .column("rest_length", "length of the unstrained bar, m", |m| {
            m.length
        })
        .column("material", "skeleton or actuator", |m| made_of(m.material))
        .column("part", part_says, |m| part(&materials.parts, m.material))
        .columns(["outer", "inner"], size_says, |m, k| {
            section(m, &materials.parts)[k]
        })
        .column("stroke", stroke_says, |m| stroke(m, materials))
        .column("stiffness", "N/m", stiffness)
        .column("mass", "mass of the bar with its fittings, kg", |m| {
            mass(materials, m.material, m.length)
        })
        .column("peak_tension", "largest pull, N", |m| loads[m.edge].tension)
        .column("peak_compression", "largest push, N", |m| {
            loads[m.edge].compression
        })
        .column("peak_force", "largest pull or push, N", |m| {
            loads[m.edge].force.peak
        })
        .column("peak_strain", "largest strain", |m| {
            loads[m.edge].strain.peak
        })
        .column("euler_safety", euler_says, safety)
        .rounded(DECIMALS)
        .done()
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

fn stroke(member: &Member, materials: &MaterialSettings) -> f64 {
    match member.material {
        Material::Actuator => materials.actuator_strain() * member.length,
        Material::Void | Material::Skeleton => 0.0,
    }
}
