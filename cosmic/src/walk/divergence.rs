//! The guard: finds the step in which a rollout diverged.
//!
//! A rollout diverges if the robot flies apart: a state becomes absurd (NaN or huge numbers), or a node becomes faster
//! than the scene allows. A guarded rollout is first [watched](Span::watched): a cheap check finds out whether some
//! state may be absurd or too fast. If so, the rollout is repeated, and every state is checked exactly.

use std::collections::VecDeque;
use std::ops::ControlFlow;

use autodiff::{Parameters, Real};

use super::blame::{Cause, blame};
use crate::error::Error;
use crate::geometry::Vector;
use crate::lattice::State;
use crate::world::{Robot, Span, Trajectory, World};

/// The number of states in a [`Divergence`] before the state that is absurd or too fast.
const KEPT: usize = 8;

/// The first state of a rollout that is absurd or too fast.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// The step that produced the state, counted from 0.
    pub step: usize,
    /// The first node that is absurd or too fast in that state.
    pub node: usize,
    /// The position of that node in the world's frame, m.
    pub position: Vector<f64>,
    /// The velocity of that node, m/s.
    pub velocity: Vector<f64>,
    /// The part of the step that caused the divergence, or the speed bound that was exceeded.
    pub term: Cause,
    /// The last states of the rollout. The last of them is the state that is absurd or too fast.
    pub last: Trajectory<f64>,
}

/// The result of a guarded rollout: the observed states, and the first state that is absurd or too fast.
#[derive(Clone, Debug, PartialEq)]
pub struct GuardedRollout {
    /// The observed states, with the same bits as those of [`World::run`].
    pub trajectory: Trajectory<f64>,
    /// The first state that is absurd or too fast, whether or not it is observed. The start is not checked.
    pub divergence: Option<Divergence>,
}

impl From<&Divergence> for Error {
    fn from(divergence: &Divergence) -> Self {
        Error::Diverged {
            step: divergence.step,
            node: divergence.node,
            position: divergence.position,
            velocity: divergence.velocity,
            cause: divergence.term.to_string(),
        }
    }
}

/// Simulates a rollout and detects every state that is absurd or too fast. If there is none, the extra cost is one
/// comparison per number of each state. If there is one, the extra cost is up to two more rollouts.
///
/// # Panics
/// Like [`run`](World::run).
pub fn guarded(world: &World, robot: &Robot<f64>, span: &Span) -> GuardedRollout {
    match watched(world, std::slice::from_ref(robot), span).remove(0) {
        Some(trajectory) => GuardedRollout {
            trajectory,
            divergence: None,
        },
        None => GuardedRollout {
            trajectory: world.run_one(robot, span),
            divergence: divergence(world, robot, span),
        },
    }
}

/// Simulates rollouts with the cheap check, and returns the observed states of each. `None` if some state may be absurd or too
/// fast: whether it is, [`divergence`] finds out.
///
/// # Panics
/// Like [`run`](World::run).
pub(crate) fn watched<R: Real>(
    world: &World,
    robots: &[Robot<R>],
    span: &Span,
) -> Vec<Option<Trajectory<R>>> {
    let watched = Span {
        watched: true,
        ..span.clone()
    };
    let cleared = |seen: Trajectory<R>| {
        // The last observed state is NaN if a state failed the check.
        let fails = |last: &State<R>| last.map(R::primal).is_absurd();
        (!seen.states.last().is_some_and(fails)).then_some(seen)
    };
    let seen = world.run(robots, &watched).into_iter();
    seen.map(cleared).collect()
}

/// Simulates all steps of a span, and returns the first absurd or too fast state, or `None`. The start is not checked.
///
/// # Panics
/// Like [`guarded`].
pub fn divergence(world: &World, robot: &Robot<f64>, span: &Span) -> Option<Divergence> {
    let mut last = VecDeque::from([(span.first, robot.start.clone())]);
    let mut found = None;
    let plain = Span {
        metered: false,
        ..span.clone()
    };
    world.each_state(robot, &plain, |step, state, _| {
        let absurd = state.absurd_node().map(|node| (node, None));
        let too_fast = || {
            let bound = world.physics().speed_bound?;
            let (node, speed) = state.too_fast(bound)?;
            Some((node, Some(Cause::TooFast { speed, bound })))
        };
        found = absurd.or_else(too_fast);
        last.push_back((step, state));
        if found.is_some() {
            return ControlFlow::Break(());
        }
        if last.len() > KEPT {
            last.pop_front();
        }
        ControlFlow::Continue(())
    });
    let (node, bound) = found?;
    Some(diagnose(world, (robot, span), node, bound, last))
}

/// Describes the divergence at `node` in the last state of `last`. `bound` is given if the node exceeds the speed bound.
fn diagnose(
    world: &World,
    (robot, span): (&Robot<f64>, &Span),
    node: usize,
    bound: Option<Cause>,
    last: VecDeque<(usize, State<f64>)>,
) -> Divergence {
    let (steps, states): (Vec<usize>, Vec<State<f64>>) = last.into_iter().unzip();
    let [.., before, after] = &states[..] else {
        unreachable!("the start is never absurd, so a state precedes the absurd one")
    };
    let step = steps[steps.len() - 2];
    let blamed = || {
        let of_step = step - span.first;
        let robot = world.during(robot, of_step..of_step + 1);
        // In open loop the policy sees one state in every step.
        let seen = span.open_loop.as_ref().unwrap_or(before);
        blame(world, (&robot, seen), before, step, node)
    };
    Divergence {
        step,
        node,
        position: after.x[node],
        velocity: after.v[node],
        term: bound.unwrap_or_else(blamed),
        last: Trajectory::new(steps, states),
    }
}
