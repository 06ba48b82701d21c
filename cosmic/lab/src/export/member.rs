//! The bars of the exported robot: the solid edges of a layout.

use crate::report::RobotFiles;
use cosmic::design::Material;
use cosmic::error::{Error, Result};
use cosmic::geometry::{Segment, Vector};
use std::collections::BTreeSet;

/// A bar of the exported robot.
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

impl Member {
    /// Returns the name of the bar's material in files.
    pub(super) fn made_of(&self) -> &'static str {
        match self.material {
            Material::Actuator => "actuator",
            Material::Void | Material::Skeleton => "skeleton",
        }
    }
}

/// Returns the nodes at which bars end.
pub(super) fn nodes_of(members: &[Member]) -> BTreeSet<usize> {
    members.iter().flat_map(|member| member.nodes).collect()
}

/// Returns the position of a node along and above the ground, in metres.
pub(super) fn place(robot: &RobotFiles, node: usize) -> Vector<f64> {
    robot.lattice.places[node] * robot.lattice.spacing
}

/// Returns the bars of a robot, which are its solid edges. Fails if there are none.
pub(super) fn members(robot: &RobotFiles) -> Result<Vec<Member>> {
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
    let solid = robot.edges_of(Material::is_solid);
    if solid.is_empty() {
        return Err(Error::Usage(
            "cannot export: all edges of the robot are void, so there is nothing to export".into(),
        ));
    }
    Ok(solid.into_iter().map(member).collect())
}
