//! The solid: round struts between joints, all of one density.
//!
//! - **Sections.** The radius of skeleton struts is given; that of actuators is such that both have the
//!   ratio of their line densities. One density, line density over section, then weighs all.
//! - **Struts** end short of their nodes, where the next strut of the node in the plane would begin to
//!   touch. Struts that cross, or meet at too small an angle, are in different planes.
//! - **Joints** are flat prisms with a face for each strut, in each plane of the node one, with a thin
//!   column between two of them. They are as thick as makes their volume that of the struts' missing
//!   ends.
//!
//! So no two parts overlap, the volume is exactly the sum of section times rest length, and the mass is
//! that of the body's bars.

use super::joint::{Disc, Joint, Radii, SIDES, joint};
use super::layers::{Stack, joints};
use super::member::{MM, Member};
use super::sizes::{Sizes, misfit};
use super::stl::Prism;
use crate::report::RobotFiles;
use crate::table::{Column, Table};
use cosmic::design::Material;
use cosmic::error::Result;
use std::f64::consts::TAU;

/// The most of the shortest bar at a node that goes into the joint: less than a half leaves a strut.
const MOST: f64 = 0.4;

/// The kinds of parts of the solid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Strut(Material),
    Joint,
}

impl Kind {
    pub(super) fn is_actuator(self) -> bool {
        self == Self::Strut(Material::Actuator)
    }
}

/// Struts and joints.
pub(super) struct Frame {
    members: Vec<Member>,
    radii: Radii,
    /// The plane of each strut.
    levels: Vec<usize>,
    joints: Vec<Joint>,
    /// Distance of two neighbouring planes, mm.
    pitch: f64,
    /// Line densities of the materials, kg/m.
    density: [f64; 3],
}

impl Frame {
    pub(super) fn new(robot: &RobotFiles, members: Vec<Member>, sizes: &Sizes) -> Result<Self> {
        let radii = Radii::new(robot, &members, sizes.radius)?;
        let thickest = members.iter().map(|m| radii.reach(m)).fold(0.0, f64::max);
        let room = |node: usize| MOST * shortest_at(&members, node);
        let conflict = |a: &Member, b: &Member| match a.meets(b) {
            Some(node) => radii.trim(node, a, b) > room(node),
            None => a.distance(b) < radii.reach(a) + radii.reach(b) + sizes.gap,
        };
        let stack = Stack::new(&members, 2.0 * thickest, conflict);
        let joint = |(node, place)| joint(node, place, &members, &stack, &radii);
        let mut joints: Vec<Joint> = joints(&members).into_iter().map(joint).collect();
        let tight = joints.iter().find(|joint| joint.trim > room(joint.node));
        if let Some(joint) = tight {
            return Err(misfit(format!(
                "the struts at node {} would have to end {:.2} mm from it, more than the {:.2} mm that \
                 their shortest has to spare: choose a smaller radius than {} mm",
                joint.node,
                joint.trim,
                room(joint.node),
                sizes.radius
            )));
        }
        let pitch = pitch(&joints, 2.0 * thickest, sizes.gap);
        joints
            .iter_mut()
            .for_each(|joint| joint.make_columns(pitch));
        let frame = Self {
            levels: stack.of_member,
            density: robot.scene.materials.density,
            members,
            radii,
            joints,
            pitch,
        };
        frame.check().map(|()| frame)
    }

    /// Refuses a joint that other bars or joints would go through.
    fn check(&self) -> Result<()> {
        let apart = |a: [f64; 2], b: [f64; 2]| a[1] <= b[0] || b[1] <= a[0];
        for (k, joint) in self.joints.iter().enumerate() {
            let heights = joint.heights(self.pitch);
            for (member, &level) in self.members.iter().zip(&self.levels) {
                let (z, reach) = (level as f64 * self.pitch, self.radii.reach(member));
                if !member.nodes.contains(&joint.node)
                    && member.distance_to(joint.place) < joint.reach() + reach
                    && !apart(heights, [z - reach, z + reach])
                {
                    return Err(misfit(format!(
                        "the strut of edge {} would go through the joint at node {}: choose a smaller \
                         radius",
                        member.edge, joint.node
                    )));
                }
            }
            for other in &self.joints[k + 1..] {
                let [dx, dy] = [0, 1].map(|k| joint.place[k] - other.place[k]);
                if dx.hypot(dy) < joint.reach() + other.reach()
                    && !apart(heights, other.heights(self.pitch))
                {
                    return Err(misfit(format!(
                        "the joints at the nodes {} and {} would overlap: choose a smaller radius",
                        joint.node, other.node
                    )));
                }
            }
        }
        Ok(())
    }

    /// The trims of a strut at its two ends, mm.
    fn trims(&self, member: &Member) -> [f64; 2] {
        let at = |node: usize| self.joints.iter().find(|joint| joint.node == node);
        member
            .nodes
            .map(|node| at(node).map_or(0.0, |joint| joint.trim))
    }

    /// The parts of some kinds.
    pub(super) fn prisms(&self, is_asked: impl Fn(Kind) -> bool) -> Vec<Prism> {
        let own = self.members.iter().zip(&self.levels);
        let own = own.filter(|(member, _)| is_asked(Kind::Strut(member.material)));
        let mut prisms: Vec<Prism> = own.map(|(m, &level)| self.strut(m, level)).collect();
        if is_asked(Kind::Joint) {
            let parts = self.joints.iter().map(|joint| joint.prisms(self.pitch));
            prisms.extend(parts.flatten());
        }
        prisms
    }

    fn strut(&self, member: &Member, level: usize) -> Prism {
        let [from, to] = self.trims(member);
        let ([ux, uy], [a, _]) = (member.direction(), member.ends);
        let z = level as f64 * self.pitch;
        let corner = |k: usize| {
            let (up, left) = (TAU * k as f64 / SIDES as f64).sin_cos();
            let reach = self.radii.reach(member);
            [
                a[0] + from * ux - reach * left * uy,
                a[1] + from * uy + reach * left * ux,
                z + reach * up,
            ]
        };
        let length = member.span() - from - to;
        Prism {
            base: (0..SIDES).map(corner).collect(),
            along: [length * ux, length * uy, 0.0],
        }
    }

    /// A row for each file: what is in it, and what that weighs.
    pub(super) fn table(&self) -> Table {
        let (mut volumes, mut counts) = ([0.0; 3], [0; 3]);
        let cubic_metres = |mm3: f64| mm3 / MM.powi(3);
        let density = {
            let (first, section) = (&self.members[0], self.radii.section(&self.members[0]));
            first.material.of(&self.density) / (section / MM.powi(2))
        };
        for member in &self.members {
            let [from, to] = self.trims(member);
            let kind = member.material as usize;
            volumes[kind] += self.radii.section(member) * (member.span() - from - to);
            volumes[0] += self.radii.section(member) * (from + to);
            counts[kind] += 1;
        }
        counts[0] = self.joints.len();
        let row = |name: &str, kinds: &[usize], radius: Option<f64>| {
            let volume = cubic_metres(kinds.iter().map(|&k| volumes[k]).sum());
            vec![
                name.into(),
                kinds.iter().map(|&k| counts[k]).sum::<usize>().into(),
                radius.map(|r| r / MM).into(),
                volume.into(),
                density.into(),
                (volume * density).into(),
            ]
        };
        let [_, skeleton, actuator] = self.radii.of;
        // To nanometres, 1e-6 cubic millimetres and micrograms.
        let columns = [
            ("part", "what is weighed", 0),
            ("count", "how many struts or joints", 0),
            ("radius", "radius of the struts, m", 9),
            ("volume", "m3", 15),
            (
                "density",
                "with which all weigh what the body's bars do, kg/m3",
                9,
            ),
            ("mass", "kg", 9),
        ];
        let column = |(name, says, decimals)| Column::new(name, says).rounded(decimals);
        let columns = columns.map(column);
        let rows = [
            row("skeleton", &[1], Some(skeleton)),
            row("actuators", &[2], Some(actuator)),
            row("joints", &[0], None),
            row("robot", &[0, 1, 2], None),
        ];
        Table::new(columns.into(), rows)
    }
}

/// The distance of planes: enough for struts, and for the discs of joints that are thicker than those.
fn pitch(joints: &[Joint], strut: f64, gap: f64) -> f64 {
    let needed = |d: &[Disc]| {
        let levels = (d[1].level - d[0].level) as f64;
        (0.5 * (d[0].height + d[1].height) + gap) / levels
    };
    let needed = joints.iter().flat_map(|j| j.discs.windows(2).map(needed));
    needed.fold(strut + gap, f64::max)
}

/// The length of the shortest bar at a node, mm.
fn shortest_at(members: &[Member], node: usize) -> f64 {
    let own = members.iter().filter(|m| m.nodes.contains(&node));
    own.map(Member::span).fold(f64::MAX, f64::min)
}
