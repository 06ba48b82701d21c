//! Prepares a robot's rollout for drawing: bars coloured by strain, in the frame of the world.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use super::files::RobotFiles;
use super::picture::{Colour, PAPER};
use cosmic::design::{Material, joined_to_payload};
use cosmic::geometry::{Bounds, Dimension, Ground, Profile, Range, Segment, Vector, mean};
use cosmic::judge::verdict::SKELETON_STRAINS;
use cosmic::lattice::State;
use cosmic::policy::Goals;
use cosmic::record::TrajectoryFile;
use cosmic::scene::{GoalKind, Scene};

/// The colour of skeleton bars without strain.
pub const SKELETON: Colour = Colour::hex(0x262b33);
/// The colour of the payload and its path.
pub(super) const PAYLOAD: Colour = Colour::hex(0xe68a00);
/// The colour of an actuator at the largest contraction.
pub const CONTRACTED: Colour = Colour::hex(0x0b4fc4);
/// The colour of an actuator at rest.
pub const AT_REST: Colour = Colour::hex(0xb4aeba);
/// The colour of an actuator at the largest extension.
pub const EXTENDED: Colour = Colour::hex(0xd61f1f);
/// The colour of a bar beyond its largest strain.
pub const BEYOND: Colour = Colour::hex(0xb800b8);

/// The largest number of frames of an animation.
const MOST_FRAMES: usize = 2000;

/// A node counts as on the ground if its height above the ground, as a share of the lattice's scale, is below this.
/// Contact puts nodes exactly onto the ground, except for rounding.
pub(super) const TOUCHES: f64 = 1e-6;

/// [`DrawnMotion::floor`] divides the width of the lattice into this many intervals and averages the heights at their ends.
const FLOORS: u32 = 16;

/// An edge of the robot in one state, ready to be drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnEdge {
    /// The line from the edge's first node to its second, in metres.
    pub line: Segment,
    /// The colour.
    pub colour: Colour,
    /// True for an actuator.
    pub actuator: bool,
    /// True if the edge is more void than solid.
    pub faint: bool,
}

/// A goal of a robot, ready to be drawn as a flag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flag {
    /// When the goal begins, in seconds.
    pub from: f64,
    /// The point of the ground below the goal, in the world.
    pub foot: Vector<f64>,
    /// The place of the goal along the ground and across, in metres from the payload at the start.
    pub place: [f64; 2],
}

/// The places at which a node touches the ground without a break: where it lands, and how it slides from there.
#[derive(Clone, Debug, PartialEq)]
pub struct Footfall {
    /// The node.
    pub node: usize,
    /// Its positions, in metres, from landing to lift-off. There is at least one.
    pub places: Vec<Vector<f64>>,
}

/// A robot's rollout, prepared for drawing.
pub struct DrawnMotion<'r> {
    pub(super) robot: &'r RobotFiles,
    trajectory: &'r TrajectoryFile,
    /// The nodes that a chain of solid edges connects to the payload.
    body: Vec<usize>,
    /// The payload's node and the ends of solid edges, ascending.
    pub seen: Vec<usize>,
    /// For each edge, the fraction of solid material in its mixture. An edge with a smaller fraction is drawn fainter.
    presence: Vec<f64>,
    /// The largest target strain of an actuator. At this strain, an actuator has its full colour.
    pub limit: f64,
    /// The terrain, as heights above the ground's line.
    pub(super) profile: Profile,
    /// The goals of the robot; `None` if its goal is a number of its controller.
    goals: Option<Goals>,
}

impl<'r> DrawnMotion<'r> {
    /// Prepares the rollout of a robot. If the robot takes goals, its goal is the one of the scene.
    pub fn new(robot: &'r RobotFiles, trajectory: &'r TrajectoryFile) -> Self {
        let largest = robot.scene.materials.actuator_strain();
        let controller = &robot.scene.controller;
        let joined = joined_to_payload(&robot.lattice, &robot.design.materials);
        Self {
            robot,
            trajectory,
            body: (0..robot.lattice.nodes())
                .filter(|&node| joined[node])
                .collect(),
            seen: seen(robot),
            presence: (robot.mixtures(&robot.design.z).iter())
                .map(|mixture| 1.0 - mixture[Material::Void])
                .collect(),
            limit: if largest > 0.0 { largest } else { 1.0 },
            profile: robot.scene.physics.ground.resolved(),
            goals: (controller.goals == GoalKind::Given).then(|| Goals::at(controller.goal)),
        }
    }

    /// This rollout with other goals.
    #[must_use]
    pub fn with_goals(self, goals: &Goals) -> Self {
        Self {
            goals: Some(goals.clone()),
            ..self
        }
    }

    /// Returns a flag for each goal that begins before the end of the rollout, in the order of time.
    pub fn flags(&self) -> Vec<Flag> {
        let ground = self.ground();
        let start = self.payload(&self.states()[0]);
        let last = self.trajectory.steps[self.states().len() - 1];
        let flag = |(time, goal): (std::ops::Range<usize>, Vector<f64>)| {
            let along = goal.forward() - ground.along(start);
            let x = start.forward() + along * ground.tangent().forward();
            Flag {
                from: time.start as f64 * self.trajectory.dt,
                foot: Vector::new([x, goal.sideways(), self.ground_height(x)]),
                place: [along, goal.sideways() - start.sideways()],
            }
        };
        let goals = self.goals.iter();
        goals
            .flat_map(|goals| goals.times(last))
            .map(flag)
            .collect()
    }

    /// Returns the flag of the goal that holds at the state `index`.
    pub(super) fn flag(&self, index: usize) -> Option<Flag> {
        let time = self.time(index);
        self.flags().into_iter().rfind(|flag| flag.from <= time)
    }

    pub(super) fn scene(&self) -> &'r Scene {
        &self.robot.scene
    }

    /// The states of the trajectory.
    pub fn states(&self) -> &'r [State<f64>] {
        &self.trajectory.states
    }

    /// Returns the time of the state `index`, in seconds from the start.
    pub fn time(&self, index: usize) -> f64 {
        self.trajectory.steps[index] as f64 * self.trajectory.dt
    }

    /// Returns the index of the last state at or before a time; 0 if there is no such state.
    pub fn index_at(&self, time: f64) -> usize {
        // Times are rounded products of a step and dt, so round to the nearest step.
        let step = (time / self.trajectory.dt + 0.5) as usize;
        let after = self.trajectory.steps.partition_point(|&s| s <= step);
        after.saturating_sub(1)
    }

    /// Returns two things: the interval between frames in seconds, and the indices of the states that the frames show.
    /// The interval is `seconds`, or longer if the rollout would otherwise have too many frames.
    pub(super) fn every(&self, seconds: f64) -> (f64, Vec<usize>) {
        let most = MOST_FRAMES as f64;
        let seconds = seconds.max(self.duration() / most);
        let frames = (self.duration() / seconds).min(most) as usize;
        let indices = (0..=frames).map(|k| self.index_at(seconds * k as f64));
        (seconds, indices.collect())
    }

    /// Returns the duration of the rollout, in seconds.
    pub fn duration(&self) -> f64 {
        self.time(self.states().len() - 1)
    }

    /// Returns the solid edges as they are drawn in a state. Faint edges come first and actuators last, so that
    /// actuators are on top.
    pub fn bars(&self, state: &State<f64>) -> Vec<DrawnEdge> {
        let (design, lattice) = (&self.robot.design, &self.robot.lattice);
        let bar = |(e, material): (usize, &Material)| {
            let [from, to] = design.edges[e].map(|node| state.x[node]);
            let line = Segment::new(from, to);
            let strain = line.length() / lattice.rest_length[e] - 1.0;
            let colour = match material {
                Material::Void => return None,
                Material::Skeleton => strained_skeleton(strain),
                Material::Actuator => self.colour(strain),
            };
            Some(DrawnEdge {
                line,
                colour: PAPER.mixed(colour, self.presence[e]),
                faint: self.presence[e] < 0.5,
                actuator: *material == Material::Actuator,
            })
        };
        let edges = design.materials.iter().enumerate();
        let mut bars: Vec<DrawnEdge> = edges.filter_map(bar).collect();
        bars.sort_by_key(|bar| (!bar.faint, bar.actuator));
        bars
    }

    /// Returns the colour of an actuator that has this strain.
    pub(super) fn colour(&self, strain: f64) -> Colour {
        strained(strain / self.limit)
    }

    /// Returns the position of the payload in a state.
    pub(super) fn payload(&self, state: &State<f64>) -> Vector<f64> {
        state.x[self.robot.lattice.payload[0].node]
    }

    /// Returns the positions of the payload in all states.
    pub(super) fn path(&self) -> Vec<Vector<f64>> {
        (self.states().iter())
            .map(|state| self.payload(state))
            .collect()
    }

    /// Returns the middle of [`DrawnMotion::bounds`].
    pub(super) fn centre(&self, state: &State<f64>) -> Vector<f64> {
        self.bounds(state).centre()
    }

    /// Returns the bounding box of the body that carries the payload: of all nodes that a chain of solid edges connects
    /// to the payload.
    pub fn bounds(&self, state: &State<f64>) -> Bounds {
        Bounds::of(self.body.iter().map(|&node| state.x[node]))
    }

    /// True if the robot moves in space.
    pub(super) fn in_space(&self) -> bool {
        self.robot.lattice.dimension == Dimension::Space
    }

    /// Returns the positions of the body that carries the payload.
    pub(super) fn body_at(&self, state: &'r State<f64>) -> impl Iterator<Item = Vector<f64>> {
        self.body.iter().map(|&node| state.x[node])
    }

    /// Returns the footfalls of the body that carries the payload, node by node, as far as the states of the trajectory
    /// show them.
    pub fn footfalls(&self) -> Vec<Footfall> {
        let most = TOUCHES * self.robot.lattice.scale;
        let touches = |x: &Vector<f64>| x.up() - self.ground_height(x.forward()) < most;
        let of_node = |&node: &usize| {
            let places: Vec<Vector<f64>> =
                self.states().iter().map(|state| state.x[node]).collect();
            let runs = places.chunk_by(|a, b| touches(a) == touches(b));
            let falls = runs.filter(|run| touches(&run[0]));
            let falls = falls.map(|run| Footfall {
                node,
                places: run.to_vec(),
            });
            falls.collect::<Vec<_>>()
        };
        self.body.iter().flat_map(of_node).collect()
    }

    /// True if the middle of a bar is near the body that carries the payload: at most the lattice's width away,
    /// horizontally.
    pub(super) fn is_near(&self, bar: &DrawnEdge, state: &State<f64>) -> bool {
        let width = self.robot.lattice.width();
        let Bounds { low, high } = self.bounds(state);
        let middle = bar.line.middle().forward();
        (low.forward() - width..high.forward() + width).contains(&middle)
    }

    /// Returns the positions that must be visible in a picture of a state: the payload, and the ends of solid edges.
    pub fn places(&self, state: &'r State<f64>) -> impl Iterator<Item = Vector<f64>> {
        self.seen.iter().map(|&node| state.x[node])
    }

    /// Returns the point at which the camera looks: the middle of the body that carries the payload, averaged over a
    /// second so that the picture does not shake.
    pub(super) fn camera(&self, index: usize) -> Vector<f64> {
        let around = self.around(index);
        let centres: Vec<Vector<f64>> = around.map(|i| self.centre(&self.states()[i])).collect();
        mean(&centres)
    }

    /// Returns the height that the camera must show: that of the body, with its highest places within half a second,
    /// averaged over a second so that the picture does not shake.
    pub(super) fn top(&self, index: usize) -> f64 {
        let height = |i: usize| self.bounds(&self.states()[i]).high.up();
        let highest = |i: usize| self.around(i).map(height).fold(f64::NEG_INFINITY, f64::max);
        let around = self.around(index);
        let count = around.clone().count() as f64;
        around.map(highest).sum::<f64>() / count
    }

    /// Returns the indices of the states within half a second.
    fn around(&self, index: usize) -> RangeInclusive<usize> {
        let time = self.time(index);
        self.index_at((time - 0.5).max(0.0))..=self.index_at(time + 0.5)
    }

    /// Returns the height of the terrain in the world, above the point of the ground's line whose horizontal position
    /// is `x`.
    pub fn ground_height(&self, x: f64) -> f64 {
        self.profile.height_in_world(&self.ground(), x)
    }

    /// Returns the terrain as points of the world. It covers the part of the ground's line whose horizontal positions
    /// are in the range `across`.
    pub fn ground_line(&self, across: Range) -> Vec<Vector<f64>> {
        self.profile.in_world(&self.ground(), across)
    }

    /// Returns the mean height of the terrain around `x`, over the lattice's width. A camera that follows this height
    /// does not jump at a step in the ground.
    pub(super) fn floor(&self, x: f64) -> f64 {
        if self.profile.is_flat() {
            return self.ground_height(x);
        }
        let width = self.robot.lattice.width();
        let places = (0..=FLOORS).map(|k| x + width * (f64::from(k) / f64::from(FLOORS) - 0.5));
        places.map(|x| self.ground_height(x)).sum::<f64>() / f64::from(FLOORS + 1)
    }

    pub(super) fn ground(&self) -> Ground {
        Ground::from(&self.scene().physics)
    }
}

/// Returns the colour of an actuator with this strain. `share` is the strain divided by the largest target strain.
pub(super) fn strained(share: f64) -> Colour {
    if share.abs() > 1.0 {
        return BEYOND;
    }
    let end = if share < 0.0 { CONTRACTED } else { EXTENDED };
    AT_REST.mixed(end, share.abs())
}

/// Returns the colour of a skeleton bar with this strain: that of the skeleton up to the strain at which it is doubtful, and
/// then more and more that of bars beyond their limits.
pub fn strained_skeleton(strain: f64) -> Colour {
    let [sound, doubtful] = SKELETON_STRAINS;
    let share = ((strain.abs() - sound) / (doubtful - sound)).clamp(0.0, 1.0);
    SKELETON.mixed(BEYOND, share)
}

fn solid_edges(run: &RobotFiles) -> impl Iterator<Item = [usize; 2]> {
    let edges = run.design.edges.iter().zip(&run.design.materials);
    edges.filter(|(_, m)| m.is_solid()).map(|(e, _)| *e)
}

fn seen(run: &RobotFiles) -> Vec<usize> {
    let ends = solid_edges(run).flatten();
    let payload = run.lattice.payload[0].node;
    let nodes: BTreeSet<usize> = ends.chain([payload]).collect();
    nodes.into_iter().collect()
}
