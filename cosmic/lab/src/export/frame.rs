//! The solid robot: round struts between joints, all made of a material of one density.
//!
//! - **Cross sections.** The user chooses the radius of skeleton struts. The cross section of actuators follows from
//!   the ratio of the two line densities, so that struts of one density have the right mass.
//! - **Struts** end before they reach their node, where they would touch the next strut in the same plane. Struts that
//!   cross, or meet at too small an angle, are in different planes.
//! - **Joints** consist of flat prisms, one in each plane of the node, with a face for each strut, and of thin columns
//!   between the prisms. A joint is as thick as is needed to have the volume of the missing ends of its struts.
//!
//! As a result, no two parts overlap. The volume of the solid is exactly the sum over all bars of cross section times
//! rest length, and its mass equals the mass of the bars.

use super::joint::{Disc, Joint, Radii, SIDES, joint};
use super::layers::{Stack, joints};
use super::member::{MM, Member};
use super::sizes::{Sizes, misfit};
use super::stl::{Prism, spatial};
use crate::report::RobotFiles;
use crate::table::{Column, Table};
use cosmic::design::Material;
use cosmic::error::Result;
use cosmic::geometry::{Range, Segment};
use std::f64::consts::TAU;

/// The largest fraction of a node's shortest bar that may belong to the joint. It is below one half because there is a
/// joint at both ends.
const MOST: f64 = 0.4;

/// The kind of a part of the solid.
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

/// The solid robot: its struts and joints.
pub(super) struct Frame {
    members: Vec<Member>,
    radii: Radii,
    /// For each strut, the index of the plane in which it lies.
    levels: Vec<usize>,
    joints: Vec<Joint>,
    /// The distance between neighbouring planes, in mm.
    pitch: f64,
    /// The line density of each material, in kg/m.
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
                "the struts at node {} must end {:.2} mm before it, but the shortest strut allows at most {:.2} mm: \
                 choose a smaller radius than {} mm",
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
            density: robot
                .scene
                .materials
                .of_length(robot.lattice.spacing)
                .density,
            members,
            radii,
            joints,
            pitch,
        };
        frame.check().map(|()| frame)
    }

    /// Returns an error if a joint would overlap other struts or joints.
    fn check(&self) -> Result<()> {
        let apart = |a: Range, b: Range| a.high <= b.low || b.high <= a.low;
        for (k, joint) in self.joints.iter().enumerate() {
            let heights = joint.heights(self.pitch);
            for (member, &level) in self.members.iter().zip(&self.levels) {
                let (z, reach) = (level as f64 * self.pitch, self.radii.reach(member));
                if !member.nodes.contains(&joint.node)
                    && member.axis.distance_to(joint.place) < joint.reach() + reach
                    && !apart(heights, Range::new(z - reach, z + reach))
                {
                    return Err(misfit(format!(
                        "the strut of edge {} would go through the joint at node {}: choose a smaller \
                         radius",
                        member.edge, joint.node
                    )));
                }
            }
            for other in &self.joints[k + 1..] {
                if joint.place.distance(other.place) < joint.reach() + other.reach()
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

    /// Returns the axis of a strut, in mm, from the face of one joint to the face of the other.
    fn trimmed(&self, member: &Member) -> Segment {
        let at = |node: usize| self.joints.iter().find(|joint| joint.node == node);
        let trim = |node: usize| at(node).map_or(0.0, |joint| joint.trim);
        let ([i, j], direction) = (member.nodes, member.axis.direction());
        Segment::new(
            member.axis.from + direction * trim(i),
            member.axis.to - direction * trim(j),
        )
    }

    /// Returns the prisms of the parts whose kind satisfies `is_asked`.
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
        let axis = self.trimmed(member);
        let to_left = member.axis.direction().turned_left();
        let z = level as f64 * self.pitch;
        let corner = |k: usize| {
            let (up, left) = (TAU * k as f64 / SIDES as f64).sin_cos();
            let reach = self.radii.reach(member);
            spatial(axis.from + to_left * (reach * left), z + reach * up)
        };
        Prism {
            base: (0..SIDES).map(corner).collect(),
            along: spatial(axis.vector(), 0.0),
        }
    }

    /// Returns a table of volumes and masses, with a row for each kind of part and a row for the whole robot.
    pub(super) fn table(&self) -> Table {
        let (mut volumes, mut counts) = ([0.0; 3], [self.joints.len(), 0, 0]);
        for member in &self.members {
            let section = self.radii.section(member) / MM.powi(2);
            let strut = self.trimmed(member).length() / MM;
            let kind = member.material as usize;
            volumes[kind] += section * strut;
            volumes[0] += section * (member.axis.length() / MM - strut);
            counts[kind] += 1;
        }
        let first = &self.members[0];
        let section = self.radii.section(first) / MM.powi(2);
        let density = first.material.of(&self.density) / section;
        let [_, skeleton, actuator] = self.radii.of.map(|radius| Some(radius / MM));
        let rows = [
            ("skeleton", &[1][..], skeleton),
            ("actuators", &[2], actuator),
            ("joints", &[0], None),
            ("robot", &[0, 1, 2], None),
        ];
        let volume = |kinds: &[usize]| -> f64 { kinds.iter().map(|&k| volumes[k]).sum() };
        let count = |kinds: &[usize]| -> usize { kinds.iter().map(|&k| counts[k]).sum() };
        // Nine decimals of metres, kilograms and millilitres are enough for a workshop.
        let head = |name, says| Column::new(name, says).rounded(9);
        let cubic = Column::new("volume", "m3").rounded(15);
        let says = "the density for which every part has the mass of its bars, kg/m3";
        Table::of("", "", &rows)
            .column("part", "the kind of part", |row| row.0)
            .column("count", "number of struts or joints", |row| count(row.1))
            .add(head("radius", "radius of the struts, m"), |row| row.2)
            .add(cubic, |row| volume(row.1))
            .add(head("density", says), |_| density)
            .add(head("mass", "kg"), |row| volume(row.1) * density)
            .done()
    }
}

/// Returns the distance between neighbouring planes. It is the smallest distance at which struts in different planes,
/// and discs of a joint in different planes, are at least `gap` apart. All lengths are in mm; `strut` is the thickness
/// of the thickest strut.
fn pitch(joints: &[Joint], strut: f64, gap: f64) -> f64 {
    let needed = |d: &[Disc]| {
        let levels = (d[1].level - d[0].level) as f64;
        (0.5 * (d[0].height + d[1].height) + gap) / levels
    };
    let needed = joints.iter().flat_map(|j| j.discs.windows(2).map(needed));
    needed.fold(strut + gap, f64::max)
}

/// Returns the length of the shortest bar that ends at a node, in mm.
fn shortest_at(members: &[Member], node: usize) -> f64 {
    let own = members.iter().filter(|m| m.nodes.contains(&node));
    own.map(|m| m.axis.length()).fold(f64::MAX, f64::min)
}
