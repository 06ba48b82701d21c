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
pub(super) struct Member {
    /// The index of its edge in the lattice.
    pub(super) edge: usize,
    /// The nodes at its ends.
    pub(super) nodes: [usize; 2],
    /// The line from the first node to the second: positions along and above the ground, in mm.
    pub(super) axis: Segment,
    /// Skeleton or actuator.
    pub(super) material: Material,
    /// The rest length, in metres.
    pub(super) length: f64,
}

impl Member {
    /// Returns the name of the bar's material in files.
    pub(super) fn made_of(&self) -> &'static str {
        if self.material == Material::Actuator {
            "actuator"
        } else {
            "skeleton"
        }
    }

    /// Returns the unit vector along the bar that points away from `node`, which is one of the bar's two nodes.
    pub(super) fn away_from(&self, node: usize) -> Vector<f64> {
        let direction = self.axis.direction();
        if node == self.nodes[0] {
            direction
        } else {
            -direction
        }
    }

    /// Returns the node that two bars share, if any.
    pub(super) fn meets(&self, other: &Self) -> Option<usize> {
        let is_shared = |node: &usize| other.nodes.contains(node);
        self.nodes.into_iter().find(is_shared)
    }

    /// Returns the smallest distance between the axes of two bars, in mm; 0 if they cross.
    pub(super) fn distance(&self, other: &Self) -> f64 {
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

#[cfg(test)]
pub(super) fn sample(edge: usize, nodes: [usize; 2], [from, to]: [[f64; 2]; 2]) -> Member {
    let mut member = Member {
        edge,
        nodes,
        axis: Segment::new(from.into(), to.into()),
        material: Material::Skeleton,
        length: 0.0,
    };
    member.length = member.axis.length() / MM;
    member
}

#[cfg(test)]
mod tests {
    use super::sample;

    #[test]
    fn bars_that_cross_have_the_distance_0_and_others_the_distance_of_their_nearest_points() {
        let bar = |ends| sample(0, [0, 1], ends);
        let level = bar([[0.0, 0.0], [10.0, 0.0]]);
        for (ends, distance) in [
            ([[5.0, -5.0], [5.0, 5.0]], 0.0),
            ([[10.0, 0.0], [20.0, 3.0]], 0.0),
            ([[4.0, 0.0], [6.0, 0.0]], 0.0),
            ([[5.0, 2.0], [5.0, 9.0]], 2.0),
            ([[13.0, 4.0], [20.0, 4.0]], 5.0),
            ([[-3.0, 7.0], [30.0, 7.0]], 7.0),
        ] {
            let other = bar(ends);
            assert_eq!(level.distance(&other), distance, "{ends:?}");
            assert_eq!(other.distance(&level), distance, "{ends:?}");
        }
    }
}
