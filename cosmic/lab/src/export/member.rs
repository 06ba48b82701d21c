//! The bars that are made: solid edges of a layout.

use super::sizes::misfit;
use crate::report::RobotFiles;
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::lattice::cross;

/// Millimetres in a metre.
pub(super) const MM: f64 = 1e3;

/// A bar to be made. The bars of a report are the bars of a chart, those of a law have a tension.
#[derive(Clone, Debug)]
pub(super) struct Member {
    /// Its number among the edges of the lattice.
    pub(super) edge: usize,
    /// The nodes that it joins.
    pub(super) nodes: [usize; 2],
    /// Where it ends, mm along and above the ground.
    pub(super) ends: [[f64; 2]; 2],
    /// Skeleton or actuator.
    pub(super) material: Material,
    /// Rest length, m.
    pub(super) length: f64,
}

impl Member {
    /// The word for the material in files.
    pub(super) fn made_of(&self) -> &'static str {
        if self.material == Material::Actuator {
            "actuator"
        } else {
            "skeleton"
        }
    }

    /// Distance of the ends, mm.
    pub(super) fn span(&self) -> f64 {
        let [a, b] = self.ends;
        (b[0] - a[0]).hypot(b[1] - a[1])
    }

    /// Unit vector from the first end to the second.
    pub(super) fn direction(&self) -> [f64; 2] {
        let [a, b] = self.ends;
        [0, 1].map(|k| (b[k] - a[k]) / self.span())
    }

    /// Unit vector away from one of its nodes.
    pub(super) fn away_from(&self, node: usize) -> [f64; 2] {
        let direction = self.direction();
        if node == self.nodes[0] {
            direction
        } else {
            direction.map(|x| -x)
        }
    }

    /// The node at which two bars meet, if they do.
    pub(super) fn meets(&self, other: &Self) -> Option<usize> {
        let is_shared = |node: &usize| other.nodes.contains(node);
        self.nodes.into_iter().find(is_shared)
    }

    /// How near the axes of two bars come to one another, mm; 0 where they cross.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        if cross(self.ends, other.ends) {
            return 0.0;
        }
        let to_self = other.ends.map(|p| self.distance_to(p));
        let to_other = self.ends.map(|p| other.distance_to(p));
        to_self.into_iter().chain(to_other).fold(f64::MAX, f64::min)
    }

    /// Distance of a point from the axis between its ends, mm.
    pub(super) fn distance_to(&self, p: [f64; 2]) -> f64 {
        let ([a, _], u) = (self.ends, self.direction());
        let along = (p[0] - a[0]) * u[0] + (p[1] - a[1]) * u[1];
        let along = along.clamp(0.0, self.span());
        (p[0] - a[0] - along * u[0]).hypot(p[1] - a[1] - along * u[1])
    }
}

/// The place of a node, mm along and above the ground from the lower left corner of the lattice.
pub(super) fn place(robot: &RobotFiles, node: usize) -> [f64; 2] {
    robot.lattice.places[node].map(|x| x * robot.lattice.spacing * MM)
}

/// The solid edges of a robot, at least one.
pub(super) fn members(robot: &RobotFiles) -> Result<Vec<Member>> {
    let edges = robot.design.materials.iter().zip(&robot.lattice.edges);
    let member = |(edge, (&material, &nodes)): (usize, (&Material, &[usize; 2]))| Member {
        edge,
        nodes,
        ends: nodes.map(|node| place(robot, node)),
        material,
        length: robot.lattice.rest_length[edge],
    };
    let solid = edges.enumerate().filter(|(_, (m, _))| m.is_solid());
    let members: Vec<Member> = solid.map(member).collect();
    if members.is_empty() {
        return Err(misfit("the robot has no solid bar".to_owned()));
    }
    Ok(members)
}

#[cfg(test)]
pub(super) fn sample(edge: usize, nodes: [usize; 2], ends: [[f64; 2]; 2]) -> Member {
    let mut member = Member {
        edge,
        nodes,
        ends,
        material: Material::Skeleton,
        length: 0.0,
    };
    member.length = member.span() / MM;
    member
}

#[cfg(test)]
mod tests {
    use super::sample;

    #[test]
    fn bars_that_cross_have_no_distance_and_others_that_of_their_nearest_points() {
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
