//! Robots that walk to the goals that they are given.

use crate::table::{Column, Table};
use cosmic::case::Case;
use cosmic::error::{Error, Result};
use cosmic::geometry::{Dimension, Ground, Vector};
use cosmic::policy::Goals;
use cosmic::record::TrajectoryFile;
use cosmic::scene::GoalKind;
use cosmic::walk::{self, GuardedRollout};
use cosmic::world::{Robot, Span, Trajectory, World};
use std::collections::BTreeSet;
use std::ops::Range;

/// The trajectory of a walk has every 16th state.
const EVERY: usize = 16;
/// A robot whose distance from a new goal, in metres, is below this is already there.
const ARRIVED: f64 = 1e-9;

/// A robot's walk to one goal or to several goals, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// The goals.
    pub goals: Goals,
    /// The states of the robot.
    pub trajectory: TrajectoryFile,
    /// A leg for each goal that begins before the end.
    pub legs: Vec<Leg>,
    /// For each state, the time in seconds and the position along the ground in metres. The position is that of the
    /// body whose displacement counts, counted from the payload at the start.
    pub path: Vec<[f64; 2]>,
}

cosmic::keys! {
    /// The part of a walk in which one goal holds. Distances are along the ground, in space along and across.
    #[derive(Clone, Copy, Debug, PartialEq)]
    struct Leg {
        /// Place of the goal along the ground, counted from the payload at the start.
        goal: f64, "number", unit "m", columns ["goal"];
        /// Only in space: place of the goal across, counted from the payload at the start.
        across: Option<f64>, "number", unit "m", columns ["across"];
        /// When the goal begins.
        from: f64, "number", unit "s", columns ["from"] decimals 1;
        /// When the goal ends.
        until: f64, "number", unit "s", columns ["until"] decimals 1;
        /// Distance from the goal when it begins.
        way: f64, "number", unit "m", columns ["way"];
        /// Distance from the goal when it ends.
        left: f64, "number", unit "m", columns ["left"];
    }
}

impl Leg {
    /// Returns the distance that is left divided by the way; `None` if the robot was at the goal when the goal began.
    pub fn ratio(&self) -> Option<f64> {
        (self.way > ARRIVED).then(|| self.left / self.way)
    }
}

/// Returns the point to which a robot walks if its goal is this far along the ground and across, in metres, from the payload
/// at the start. Its height is that of the payload.
pub fn place(case: &Case, [along, across]: [f64; 2]) -> Vector<f64> {
    let ground = Ground::from(&case.scene.physics);
    case.lattice.payload_point(&case.start, &ground) + Vector::new([along, across, 0.0])
}

/// Simulates a walk of `steps` steps, which may be more than the scene has.
///
/// # Errors
/// [`Error::Usage`] if the goal of the robot is a number of its controller; [`Error::Diverged`].
pub fn walk(case: &Case, goals: &Goals, steps: usize) -> Result<Walk> {
    if case.scene.controller.goals != GoalKind::Given {
        return Err(Error::Usage(
            "this robot has one fixed goal, which is a number of its controller; to walk to other goals, a robot \
             needs a scene with `controller.goals = \"given\"`, such as `errand`"
                .into(),
        ));
    }
    let mut case = case.clone();
    case.scene.physics.steps = steps;
    let (world, robot) = (case.world(), case.robot().with_goals(goals.clone()));
    let trajectory = trajectory(&world, &robot, goals)?;
    let (dt, start) = (case.scene.physics.dt, place(&case, [0.0; 2]));
    let path = trajectory.steps.iter().map(|&step| {
        let along = world.ground().along(trajectory.position(step)) - start.forward();
        [step as f64 * dt, along]
    });
    let (legs, path) = (legs(&world, start, goals, &trajectory), path.collect());
    Ok(Walk {
        goals: goals.clone(),
        trajectory: TrajectoryFile {
            dt,
            steps: trajectory.steps,
            states: trajectory.states,
            bars: Vec::new(),
        },
        legs,
        path,
    })
}

/// Simulates the walk of a robot. The trajectory has the states after every 16 steps, at every change of a goal, and at the end.
///
/// # Errors
/// [`Error::Diverged`].
fn trajectory(world: &World, robot: &Robot<f64>, goals: &Goals) -> Result<Trajectory<f64>> {
    let steps = world.physics().steps;
    let times = goals
        .times(steps)
        .flat_map(|(time, _)| [time.start, time.end]);
    let observed = (0..steps).step_by(EVERY).chain(times).chain([steps]);
    let observed: BTreeSet<usize> = observed.collect();
    let span = Span::from_start(observed.into_iter().collect());
    let GuardedRollout {
        trajectory,
        divergence,
    } = walk::guarded(world, robot, &span);
    divergence.map_or(Ok(trajectory), |divergence| Err((&divergence).into()))
}

/// The legs of a [walk](trajectory) that begins with the payload at `start`, in the ground's frame, in metres.
fn legs(
    world: &World,
    start: Vector<f64>,
    goals: &Goals,
    trajectory: &Trajectory<f64>,
) -> Vec<Leg> {
    let (ground, dimension) = (world.ground(), world.lattice().dimension);
    let place = |step: usize| ground.vector_to_ground(trajectory.position(step)) - start;
    let leg = |(time, goal): (Range<usize>, Vector<f64>)| {
        let ends = [time.start, time.end];
        let [first, last] = ends.map(place);
        let [from, until] = ends.map(|step| step as f64 * world.physics().dt);
        let goal = goal - start;
        Leg {
            goal: goal.forward(),
            across: (dimension == Dimension::Space).then_some(goal.sideways()),
            from,
            until,
            way: dimension.norm_along(first - goal),
            left: dimension.norm_along(last - goal),
        }
    };
    goals.times(world.physics().steps).map(leg).collect()
}

/// Returns the table of legs, with a row for each.
pub fn table(legs: &[Leg]) -> Table {
    let says = "`left` divided by `way`: 0 at the goal, 1 if the robot came no nearer";
    let ratio = Column::new("ratio", says).decimals(2, "\u{2013}");
    Table::of("goals", "", legs)
        .keyed(Some)
        .add(ratio, Leg::ratio)
        .done()
        .without_empty()
}
