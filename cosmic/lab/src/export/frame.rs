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

use super::layers::{Stack, joints};
use super::member::{MM, Member};
use super::stl::Prism;
use super::{Sizes, misfit};
use crate::report::RobotFiles;
use crate::table::{Column, Table};
use cosmic::design::Material;
use cosmic::error::Result;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Sides of a strut. Its corners lie a little beyond the radius, so that the area is the circle's.
const SIDES: usize = 24;
/// The most of the shortest bar at a node that goes into the joint: less than a half leaves a strut.
const MOST: f64 = 0.4;
/// The most of a joint's volume that goes into its columns.
const COLUMNS: f64 = 0.2;

/// What a part of the solid is.
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

/// The radii of the struts, mm.
struct Radii {
    /// By material; 0 for void.
    of: [f64; 3],
}

impl Radii {
    fn new(robot: &RobotFiles, members: &[Member], radius: f64) -> Result<Self> {
        let density = &robot.scene.materials.density;
        let [_, skeleton, actuator] = *density;
        let is_light = |m: &&Member| density[m.material as usize] <= 0.0;
        if let Some(member) = members.iter().find(is_light) {
            return Err(misfit(format!(
                "the line density of {} is 0 (materials.density), so its struts have no section",
                member.made_of()
            )));
        }
        let ratio = if skeleton > 0.0 {
            actuator / skeleton
        } else {
            1.0
        };
        Ok(Self {
            of: [0.0, radius, radius * ratio.sqrt()],
        })
    }

    fn radius(&self, member: &Member) -> f64 {
        self.of[member.material as usize]
    }

    fn section(&self, member: &Member) -> f64 {
        PI * self.radius(member).powi(2)
    }

    /// How far the corners of a strut are from its axis.
    fn reach(&self, member: &Member) -> f64 {
        self.radius(member) * corners_at(SIDES)
    }

    /// How far from their node two struts of one plane have to end, mm: as far as keeps both on their
    /// side of the line between them, and their ends whole.
    fn trim(&self, node: usize, a: &Member, b: &Member) -> f64 {
        let ([ax, ay], [bx, by]) = (a.away_from(node), b.away_from(node));
        let between = (ax * by - ay * bx).abs().atan2(ax * bx + ay * by);
        self.reach(a).max(self.reach(b)) / (0.5 * between).tan()
    }
}

/// The distance of a regular polygon's corners from its middle, for the area of a circle of radius 1.
fn corners_at(sides: usize) -> f64 {
    let n = sides as f64;
    (TAU / (n * (TAU / n).sin())).sqrt()
}

/// The part of a joint in one plane.
struct Disc {
    level: usize,
    /// Volume of the ends that its struts lack, mm3.
    missing: f64,
    /// Thickness, mm.
    height: f64,
}

/// What holds the struts of a node together.
struct Joint {
    node: usize,
    place: [f64; 2],
    /// Distance of the faces from the node, mm.
    trim: f64,
    /// Corners around the node, counterclockwise.
    corners: Vec<[f64; 2]>,
    /// From the lowest plane to the highest.
    discs: Vec<Disc>,
    /// Area of a column between discs, mm2.
    column: f64,
}

impl Joint {
    fn area(&self) -> f64 {
        let next = self.corners.iter().cycle().skip(1);
        let cross = |(a, b): (&[f64; 2], &[f64; 2])| a[0] * b[1] - a[1] * b[0];
        0.5 * self.corners.iter().zip(next).map(cross).sum::<f64>()
    }

    /// How far it reaches from its node, mm.
    fn reach(&self) -> f64 {
        let far = self.corners.iter().map(|[x, y]| x.hypot(*y));
        far.fold(0.0, f64::max)
    }

    /// From its lowest point to its highest, mm.
    fn heights(&self, pitch: f64) -> [f64; 2] {
        let z = |disc: &Disc, side: f64| disc.level as f64 * pitch + side * 0.5 * disc.height;
        let (lowest, highest) = (&self.discs[0], &self.discs[self.discs.len() - 1]);
        [z(lowest, -1.0), z(highest, 1.0)]
    }

    /// Thins the discs, all by one factor, so that the columns between them have their volume. Until
    /// then the discs alone have the volume of what the struts lack.
    fn make_columns(&mut self, pitch: f64) {
        let pairs = || self.discs.windows(2);
        let rise: f64 = pairs()
            .map(|d| (d[1].level - d[0].level) as f64 * pitch)
            .sum();
        if rise == 0.0 {
            return;
        }
        let within: f64 = pairs().map(|d| 0.5 * (d[0].height + d[1].height)).sum();
        let missing: f64 = self.discs.iter().map(|disc| disc.missing).sum();
        self.column = self.column.min(COLUMNS * missing / rise);
        let factor = (missing - self.column * rise) / (missing - self.column * within);
        self.discs.iter_mut().for_each(|disc| disc.height *= factor);
    }

    fn prisms(&self, pitch: f64) -> Vec<Prism> {
        let prism = |corners: &[[f64; 2]], from: f64, to: f64| {
            let corner = |[x, y]: &[f64; 2]| [x + self.place[0], y + self.place[1], from];
            Prism {
                base: corners.iter().map(corner).collect(),
                along: [0.0, 0.0, to - from],
            }
        };
        let middle = |disc: &Disc| disc.level as f64 * pitch;
        let disc = |disc: &Disc| {
            let (z, half) = (middle(disc), 0.5 * disc.height);
            prism(&self.corners, z - half, z + half)
        };
        let side = 0.5 * self.column.sqrt();
        let square = [[-side, -side], [side, -side], [side, side], [-side, side]];
        let column = |d: &[Disc]| {
            let from = middle(&d[0]) + 0.5 * d[0].height;
            prism(&square, from, middle(&d[1]) - 0.5 * d[1].height)
        };
        let discs = self.discs.iter().map(disc);
        discs.chain(self.discs.windows(2).map(column)).collect()
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
            self.density[first.material as usize] / (section / MM.powi(2))
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
        let columns = [
            ("part", "what is weighed"),
            ("count", "how many struts or joints"),
            ("radius", "radius of the struts, m"),
            ("volume", "m3"),
            (
                "density",
                "with which all weigh what the body's bars do, kg/m3",
            ),
            ("mass", "kg"),
        ];
        let columns = columns.map(|(name, says)| Column::new(name, says));
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

/// The joint of a node, without columns.
fn joint(node: usize, place: [f64; 2], members: &[Member], stack: &Stack, radii: &Radii) -> Joint {
    let own = members.iter().zip(&stack.of_member);
    let own: Vec<_> = own.filter(|(m, _)| m.nodes.contains(&node)).collect();
    // A strut alone has its end whole where the joint has eight sides.
    let mut trim = own.iter().map(|(m, _)| radii.reach(m)).fold(0.0, f64::max);
    let thinnest = own
        .iter()
        .map(|(m, _)| radii.radius(m))
        .fold(f64::MAX, f64::min);
    trim /= (PI / 8.0).tan();
    for (k, (a, level)) in own.iter().enumerate() {
        let in_plane = own[k + 1..].iter().filter(|(_, other)| other == level);
        for (b, _) in in_plane {
            trim = trim.max(radii.trim(node, a, b));
        }
    }
    let angle = |(m, _): &(&Member, &usize)| {
        let [x, y] = m.away_from(node);
        y.atan2(x)
    };
    let mut joint = Joint {
        node,
        place,
        trim,
        corners: around(own.iter().map(angle).collect(), trim),
        discs: Vec::new(),
        // As wide as the thinnest strut: it lies within the discs, which are wider.
        column: 2.0 * thinnest * thinnest,
    };
    let area = joint.area();
    let mut levels: Vec<usize> = own.iter().map(|(_, level)| **level).collect();
    levels.sort_unstable();
    levels.dedup();
    let disc = |level: usize| {
        let sections = own.iter().filter(|(_, l)| **l == level);
        let missing = trim * sections.map(|(m, _)| radii.section(m)).sum::<f64>();
        let height = missing / area;
        Disc {
            level,
            missing,
            height,
        }
    };
    joint.discs = levels.into_iter().map(disc).collect();
    joint
}

/// The corners of a polygon around the origin with a side in each of these directions at a distance,
/// and as many more sides as close it: the angle between two neighbouring directions is at most a
/// right one.
fn around(mut angles: Vec<f64>, distance: f64) -> Vec<[f64; 2]> {
    angles.sort_by(f64::total_cmp);
    // Struts of different planes may lie over one another.
    angles.dedup_by(|a, b| *a - *b < 1e-6);
    let mut sides = Vec::new();
    for (k, &angle) in angles.iter().enumerate() {
        let next = angles.get(k + 1).copied().unwrap_or(angles[0] + TAU);
        // A rounding of a right angle is no more than one.
        let parts = ((next - angle) / FRAC_PI_2 - 1e-9).ceil().max(1.0);
        sides.extend((0..parts as usize).map(|p| angle + (next - angle) * p as f64 / parts));
    }
    let next = sides.iter().skip(1).copied().chain([sides[0] + TAU]);
    let corner = |(a, b): (&f64, f64)| {
        let (sin, cos) = (0.5 * (a + b)).sin_cos();
        let far = distance / (0.5 * (b - a)).cos();
        [far * cos, far * sin]
    };
    sides.iter().zip(next).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::{around, corners_at};

    #[test]
    fn a_joint_has_a_side_for_each_strut_and_is_closed() {
        use std::f64::consts::FRAC_PI_4;
        for angles in [
            vec![0.3],
            vec![-2.0, 1.0],
            vec![0.0, FRAC_PI_4, 2.0 * FRAC_PI_4],
            (0..8).map(|k| k as f64 * FRAC_PI_4 - 3.0).collect(),
        ] {
            let corners = around(angles.clone(), 2.0);
            assert!(corners.len() >= angles.len().max(4));
            for angle in angles {
                let along = |[x, y]: &[f64; 2]| x * angle.cos() + y * angle.sin();
                // All corners are behind the side, and two are its ends.
                let on_it = corners.iter().filter(|c| (along(c) - 2.0).abs() < 1e-12);
                assert_eq!(on_it.count(), 2);
                assert!(corners.iter().all(|corner| along(corner) < 2.0 + 1e-12));
            }
        }
    }

    #[test]
    fn a_polygon_has_the_area_of_its_circle() {
        let (sides, far) = (24, corners_at(24));
        let angle = std::f64::consts::TAU / sides as f64;
        let area = 0.5 * sides as f64 * far * far * angle.sin();
        assert!((area - std::f64::consts::PI).abs() < 1e-14);
    }
}
