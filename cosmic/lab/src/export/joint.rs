//! The joints of the solid, and the cross sections of its struts.

use super::layers::Stack;
use super::member::Member;
use super::sizes::misfit;
use super::stl::{Prism, spatial};
use crate::report::RobotFiles;
use cosmic::error::Result;
use cosmic::geometry::{Range, Vector};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The number of sides of a strut, which is a prism. Its corners are a little outside the circle of the given radius,
/// so that polygon and circle have equal areas.
pub(super) const SIDES: usize = 24;
/// The largest fraction of a joint's volume that its columns may have.
const COLUMNS: f64 = 0.2;

/// The radii of the struts, in mm.
pub(super) struct Radii {
    /// For each material, the radius of its struts; 0 for void.
    pub(super) of: [f64; 3],
}

impl Radii {
    pub(super) fn new(robot: &RobotFiles, members: &[Member], radius: f64) -> Result<Self> {
        let typical = robot.scene.materials.of_length(robot.lattice.spacing);
        let density = &typical.density;
        let [_, skeleton, actuator] = *density;
        let is_light = |m: &&Member| m.material.of(density) <= 0.0;
        if let Some(member) = members.iter().find(is_light) {
            return Err(misfit(format!(
                "the line density of {} is 0 (materials.density), so its struts have no section; set it above 0",
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

    pub(super) fn radius(&self, member: &Member) -> f64 {
        member.material.of(&self.of)
    }

    pub(super) fn section(&self, member: &Member) -> f64 {
        PI * self.radius(member).powi(2)
    }

    /// Returns the distance from a strut's axis to the corners of its cross section, in mm.
    pub(super) fn reach(&self, member: &Member) -> f64 {
        self.radius(member) * corners_at(SIDES)
    }

    /// Two struts, `a` and `b`, meet at `node` in one plane. Returns the distance from the node, in mm, at which both
    /// must end so that neither crosses the line half-way between them.
    pub(super) fn trim(&self, node: usize, a: &Member, b: &Member) -> f64 {
        let (one, other) = (a.away_from(node), b.away_from(node));
        let between = one.cross(other).abs().atan2(one.dot(other));
        self.reach(a).max(self.reach(b)) / (0.5 * between).tan()
    }
}

/// Returns the distance from the middle of a regular polygon to its corners. The polygon has the area of a circle of
/// radius 1.
pub fn corners_at(sides: usize) -> f64 {
    let n = sides as f64;
    (TAU / (n * (TAU / n).sin())).sqrt()
}

/// The part of a joint in one plane: a flat prism, called a disc.
pub(super) struct Disc {
    pub(super) level: usize,
    /// The volume of the strut ends that this disc replaces, in mm3.
    missing: f64,
    /// The thickness of the disc, in mm.
    pub(super) height: f64,
}

/// The part that connects the struts of a node.
pub(super) struct Joint {
    pub(super) node: usize,
    pub(super) place: Vector<f64>,
    /// The distance from the node to the faces at which struts end, in mm.
    pub(super) trim: f64,
    /// The corners of the prism's base relative to the node, counterclockwise.
    corners: Vec<Vector<f64>>,
    /// The discs of the joint, one for each plane of the node, from the lowest to the highest.
    pub(super) discs: Vec<Disc>,
    /// The cross section of the column that connects one disc with the next, in mm2.
    column: f64,
}

impl Joint {
    fn area(&self) -> f64 {
        let next = self.corners.iter().cycle().skip(1);
        let pairs = self.corners.iter().zip(next);
        0.5 * pairs.map(|(a, b)| a.cross(*b)).sum::<f64>()
    }

    /// Returns the distance from the node to the joint's farthest corner, in mm.
    pub(super) fn reach(&self) -> f64 {
        let far = self.corners.iter().map(|corner| corner.norm());
        far.fold(0.0, f64::max)
    }

    /// Returns the range of heights that the joint covers, in mm.
    pub(super) fn heights(&self, pitch: f64) -> Range {
        let z = |disc: &Disc, side: f64| disc.level as f64 * pitch + side * 0.5 * disc.height;
        let (lowest, highest) = (&self.discs[0], &self.discs[self.discs.len() - 1]);
        Range::new(z(lowest, -1.0), z(highest, 1.0))
    }

    /// Makes all discs thinner by one factor, so that there is room for the columns. Before this, the discs alone have
    /// the volume of the missing strut ends; afterwards, discs and columns together have it.
    pub(super) fn make_columns(&mut self, pitch: f64) {
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

    pub(super) fn prisms(&self, pitch: f64) -> Vec<Prism> {
        let prism = |corners: &[Vector<f64>], from: f64, to: f64| Prism {
            base: (corners.iter())
                .map(|corner| spatial(*corner + self.place, from))
                .collect(),
            along: spatial(Vector::zero(), to - from),
        };
        let middle = |disc: &Disc| disc.level as f64 * pitch;
        let disc = |disc: &Disc| {
            let (z, half) = (middle(disc), 0.5 * disc.height);
            prism(&self.corners, z - half, z + half)
        };
        let side = 0.5 * self.column.sqrt();
        let square = [[-side, -side], [side, -side], [side, side], [-side, side]].map(Vector::new);
        let column = |d: &[Disc]| {
            let from = middle(&d[0]) + 0.5 * d[0].height;
            prism(&square, from, middle(&d[1]) - 0.5 * d[1].height)
        };
        let discs = self.discs.iter().map(disc);
        discs.chain(self.discs.windows(2).map(column)).collect()
    }
}

/// Builds the joint of a node, without columns. Call [`Joint::make_columns`] afterwards.
pub(super) fn joint(
    node: usize,
    place: Vector<f64>,
    members: &[Member],
    stack: &Stack,
    radii: &Radii,
) -> Joint {
    let own = members.iter().zip(&stack.of_member);
    let own: Vec<_> = own.filter(|(m, _)| m.nodes.contains(&node)).collect();
    // With this trim, a side of a joint with up to eight equal sides is at least as wide as a strut.
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
    let angle = |(m, _): &(&Member, &usize)| m.away_from(node).angle();
    let mut joint = Joint {
        node,
        place,
        trim,
        corners: around(own.iter().map(angle).collect(), trim),
        discs: Vec::new(),
        // A column as wide as the thinnest strut does not stick out of the discs, which are wider.
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

/// Returns the corners of a polygon around the origin. The polygon has a side in the direction of each of `angles`, at
/// `distance` from the origin. Further sides are added where two neighbouring directions are more than a right angle
/// apart.
pub fn around(mut angles: Vec<f64>, distance: f64) -> Vec<Vector<f64>> {
    angles.sort_by(f64::total_cmp);
    // Struts in different planes may have the same direction. They share one side.
    angles.dedup_by(|a, b| *a - *b < 1e-6);
    let mut sides = Vec::new();
    for (k, &angle) in angles.iter().enumerate() {
        let next = angles.get(k + 1).copied().unwrap_or(angles[0] + TAU);
        // The margin of 1e-9 keeps a right angle in one part even if rounding has made it a little larger.
        let parts = ((next - angle) / FRAC_PI_2 - 1e-9).ceil().max(1.0);
        sides.extend((0..parts as usize).map(|p| angle + (next - angle) * p as f64 / parts));
    }
    let next = sides.iter().skip(1).copied().chain([sides[0] + TAU]);
    let corner = |(a, b): (&f64, f64)| {
        let far = distance / (0.5 * (b - a)).cos();
        Vector::at_angle(0.5 * (a + b)) * far
    };
    sides.iter().zip(next).map(corner).collect()
}
