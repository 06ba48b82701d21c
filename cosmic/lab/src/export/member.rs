//! The bars that the workshop makes: the solid edges of a layout.

use super::sizes::misfit;
use crate::report::RobotFiles;
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::geometry::{Segment, Vector};

/// Millimetres in a metre.
pub(super) const MM: f64 = 1e3;

/// A bar that the workshop makes.
#[derive(Clone, Debug)]
pub struct Member {
    /// The index of its edge in the lattice.
    pub edge: usize,
    /// The nodes at its ends.
    pub nodes: [usize; 2],
    /// The line from the first node to the second: positions along and above the ground, in mm.
    pub axis: Segment,
    /// Skeleton or actuator.
    pub material: Material,
    /// The rest length, in metres.
    pub length: f64,
}

impl Member {
    /// Returns the name of the bar's material in files.
    pub fn made_of(&self) -> &'static str {
        if self.material == Material::Actuator {
            "actuator"
        } else {
            "skeleton"
        }
    }

    /// Returns the unit vector along the bar that points away from `node`, which is one of the bar's two nodes.
    pub fn away_from(&self, node: usize) -> Vector<f64> {
        let direction = self.axis.direction();
        if node == self.nodes[0] {
            direction
        } else {
            -direction
        }
    }

    /// Returns the node that two bars share, if any.
    pub fn meets(&self, other: &Self) -> Option<usize> {
        let is_shared = |node: &usize| other.nodes.contains(node);
        self.nodes.into_iter().find(is_shared)
    }

    /// Returns the smallest distance between the axes of two bars, in mm; 0 if they cross.
    pub fn distance(&self, other: &Self) -> f64 {
        self.axis.distance(&other.axis)
    }
}

/// Returns the position of a node along and above the ground, in mm, relative to the lattice's lower left corner.
pub(super) fn place(robot: &RobotFiles, node: usize) -> Vector<f64> {
    robot.lattice.places[node] * robot.lattice.spacing * MM
}

/// Returns the bars of a robot, which are its solid edges. Fails if there are none.
pub(super) fn members(robot: &RobotFiles) -> Result<Vec<Member>> {
    let edges = robot.design.materials.iter().zip(&robot.lattice.edges);
    let member = |(edge, (&material, &nodes)): (usize, (&Material, &[usize; 2]))| {
        let [from, to] = nodes.map(|node| place(robot, node));
        Member {
            edge,
            nodes,
            axis: Segment::new(from, to),
            material,
            length: robot.lattice.rest_length[edge],
        }
    };
    let solid = edges.enumerate().filter(|(_, (m, _))| m.is_solid());
    let members: Vec<Member> = solid.map(member).collect();
    if members.is_empty() {
        return Err(misfit(
            "all edges of the robot are void, so there is nothing to export".to_owned(),
        ));
    }
    Ok(members)
}
