//! The robot at which gradients are checked.
//!
//! A robot that stands still has no gradient: its foot sticks to the ground for every design and every controller.
//! Then reverse mode, forward mode and differences all return zero, and nothing is compared. Such a robot is thrown.

use std::fmt;

use cosmic::case::Case;
use cosmic::geometry::Ground;
use cosmic::laws::{Actuator, ContactLaw};
use cosmic::policy::Controller;
use cosmic::random::{Purpose, stream, symmetric};

/// The height, as a share of the lattice's scale, to which a robot's lowest node is lifted above the ground. A node
/// exactly on the ground is at a kink of the loss.
pub(super) const LIFT: f64 = 1e-3;
/// A bound on the rounding errors of heights above an inclined ground, as a share of the lattice's scale.
const ON_LINE: f64 = 1e-12;
/// The share of the rollout in which a thrown robot flies; then it lands. It flies for longer than half of the rollout,
/// because some losses are means over the second half, and a foot that sticks to the ground has no slope.
const FLIGHT: f64 = 0.6;
/// The speed at which a thrown robot flies forward, as a share of the speed at which it flies up.
const FORWARD: f64 = 0.5;
/// The largest random part of a thrown node's velocity, as a share of the speed at which the robot flies up.
const SPREAD: f64 = 0.1;

/// How the robot of a check differs from the robot of the case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Perturbation {
    /// The robot is that of the case.
    No,
    /// The robot starts in the air and flies up and forward. Its design and its controller are those of the case.
    Thrown,
    /// The robot is thrown, and its controller is drawn at random.
    Driven,
}

impl Perturbation {
    /// The ways to move a robot, beginning with the smallest change.
    pub(super) const WAYS: [Self; 2] = [Self::Thrown, Self::Driven];

    /// The robot of a case, perturbed in this way.
    pub(super) fn of(self, case: &Case) -> Case {
        let mut case = case.clone();
        match self {
            Self::No => {}
            Self::Thrown => throw(&mut case),
            Self::Driven => {
                throw(&mut case);
                drive(&mut case);
            }
        }
        case
    }
}

/// A noun phrase, for sentences about the robot of the check.
impl fmt::Display for Perturbation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::No => "the robot as it is",
            Self::Thrown => "the robot thrown up and forward",
            Self::Driven => "the robot thrown up and forward, with a random controller",
        })
    }
}

/// Lets the robot fly, at such a speed that it lands in the course of the rollout.
fn throw(case: &mut Case) {
    let physics = &case.scene.physics;
    let duration = physics.steps as f64 * physics.dt;
    let up = match physics.gravity.abs() {
        // Without gravity, the robot covers its own size.
        0.0 => case.lattice.scale / duration,
        gravity => 0.5 * FLIGHT * duration * gravity,
    };
    let ground = Ground::from(physics);
    let velocity = ground.normal() * up + ground.tangent() * (FORWARD * up);
    let lowest = heights(case).into_iter().fold(f64::INFINITY, f64::min);
    let lift = ground.normal() * (LIFT * case.lattice.scale - lowest).max(0.0);
    let mut random = stream(0, Purpose::Verification);
    for (x, v) in case.start.x.iter_mut().zip(&mut case.start.v) {
        *x += lift;
        let spread = |v| v + symmetric(&mut random, SPREAD * up);
        *v = case.start.dimension.map(velocity, spread);
    }
}

/// Draws a controller whose layers keep the size of their inputs, so that no layer hides the layers below it.
fn drive(case: &mut Case) {
    let mut settings = case.scene.controller.clone();
    settings.gain = [1.0; 2];
    case.controller = Controller::xavier(&settings, &case.lattice, 0);
}

/// Returns two answers: whether a node starts on the ground line, and whether a node starts on or below it.
pub(super) fn stands_and_touches(case: &Case) -> [bool; 2] {
    let any = |is: fn(f64) -> bool| {
        let mut heights = heights(case).into_iter().map(|h| h / case.lattice.scale);
        case.scene.physics.contact != ContactLaw::none() && heights.any(is)
    };
    [any(|h| h.abs() < ON_LINE), any(|h| h < ON_LINE)]
}

/// The heights of all nodes above the terrain, m.
fn heights(case: &Case) -> Vec<f64> {
    let state = case.start.to_ground(&Ground::from(&case.scene.physics));
    let profile = case.scene.physics.ground.resolved();
    state.x.iter().map(|&x| profile.above(x)).collect()
}

/// The robot of a case, with its lowest node lifted off the ground.
pub(super) fn lifted(case: &Case) -> Case {
    let by = LIFT * case.lattice.scale - heights(case).into_iter().fold(0.0, f64::min);
    let mut case = case.clone();
    let normal = Ground::from(&case.scene.physics).normal();
    for x in &mut case.start.x {
        *x += normal * by;
    }
    case
}

/// True if the robot is at rest and a law has a kink there with respect to the velocities: at the limit of its force, an
/// actuator holds a force that falls as soon as it moves in its own direction.
pub(super) fn starts_at_a_kink(case: &Case) -> bool {
    let actuator: Option<Actuator> = case.scene.physics.forces.chosen();
    actuator.is_some() && case.start.v.iter().all(|v| v.norm() == 0.0)
}

/// The robot of a case, lifted off the ground, with a small random velocity for every node.
pub(super) fn moving(case: &Case) -> Case {
    let mut case = lifted(case);
    let mut random = stream(0, Purpose::Verification);
    let speed = LIFT * case.lattice.scale / case.scene.physics.dt;
    for v in &mut case.start.v {
        *v = case
            .start
            .dimension
            .map(*v, |v| v + symmetric(&mut random, speed));
    }
    case
}
