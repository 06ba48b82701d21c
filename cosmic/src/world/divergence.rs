//! The guard: finds the step in which a rollout diverged.
//!
//! A rollout diverges if the robot flies apart: a state becomes absurd (NaN or huge numbers), or a node becomes faster
//! than the scene allows. A guarded rollout is first [watched](Span::watched): a cheap check finds out whether some
//! state may be absurd or too fast. If so, the rollout is repeated, and every state is checked exactly.

use std::collections::VecDeque;
use std::ops::ControlFlow;

use super::base::World;
use super::blame::Cause;
use super::effort::Effort;
use super::robot::Robot;
use super::span::Span;
use super::trajectory::{AbsentNodes, Trajectory, WATCHED};
use crate::error::Error;
use crate::geometry::Vector;
use crate::lattice::State;

/// The number of states that the repeated rollout keeps in memory at a time.
const BLOCK: usize = 64;
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

impl World {
    /// Simulates a rollout and detects every state that is absurd or too fast. If there is none, the extra cost is one
    /// comparison per number of each state. If there is one, the extra cost is up to two more rollouts.
    ///
    /// # Panics
    /// Like [`run`](World::run), and if the robot diverges with activations that are given step by step.
    pub fn guarded(&self, robot: &Robot<f64>, span: &Span) -> GuardedRollout {
        let watched = Span {
            watched: true,
            ..span.clone()
        };
        let seen = self.run_one(robot, &watched);
        if seen.states.last().is_none_or(|last| self.is_cleared(last)) {
            return GuardedRollout {
                trajectory: seen,
                divergence: None,
            };
        }
        GuardedRollout {
            trajectory: self.run_one(robot, span),
            divergence: self.divergence(robot, span),
        }
    }

    /// A limit for the cheap watch of a rollout. If the absolute value of a number of some state exceeds it, every state
    /// is checked exactly. Positions (m) and velocities (m/s) share the limit. With a bound on speeds, a valid position
    /// may exceed it; the exact check then finds no error.
    pub(super) fn watched(&self) -> f64 {
        // If both components of a velocity are below this number, the speed is below the bound.
        let component = |bound: f64| bound / 2f64.sqrt();
        self.physics
            .speed_bound
            .map_or(WATCHED, |bound| component(bound).min(WATCHED))
    }

    /// Decides by the last state of a watched rollout whether all of its states are fine. Returns false if a state may
    /// have been absurd or too fast; [`guarded`](World::guarded) then checks every state.
    pub fn is_cleared(&self, last: &State<f64>) -> bool {
        !last.is_absurd()
    }

    /// Simulates all steps of a span, and returns the first absurd or too fast state, or `None`. The start is not checked.
    ///
    /// # Panics
    /// Like [`guarded`](World::guarded).
    pub fn divergence(&self, robot: &Robot<f64>, span: &Span) -> Option<Divergence> {
        let mut last = VecDeque::from([(span.first, robot.start.clone())]);
        let mut found = None;
        let plain = Span {
            metered: false,
            ..span.clone()
        };
        self.each_state(robot, &plain, |step, state, _| {
            let absurd = state.absurd_node().map(|node| (node, None));
            let too_fast = || {
                let bound = self.physics.speed_bound?;
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
        // In open loop the policy sees one state in every step.
        let seen = span.open_loop.as_ref();
        Some(self.diagnose((robot, seen), node, bound, last))
    }

    /// Simulates all steps of a span. After each step, calls `show` with the number of steps so far and the new state; if the
    /// span is metered, also with the efforts of the bars in the step. Ends early if `show` returns `Break`. Keeps only a
    /// block of states in memory at a time.
    pub(super) fn each_state(
        &self,
        robot: &Robot<f64>,
        span: &Span,
        mut show: impl FnMut(usize, State<f64>, Option<Effort<f64>>) -> ControlFlow<()>,
    ) {
        let of_nodes = self.step.numbers_of_nodes();
        // Every node of every state is needed, and nothing is watched.
        let part = |first: usize, observed: Vec<usize>| Span {
            first,
            nodes: usize::MAX,
            watched: false,
            ..span.observing(observed)
        };
        let planned = self.planned(std::slice::from_ref(robot), &part(0, vec![BLOCK]));
        let size = of_nodes + planned.model.meters();
        let still = AbsentNodes::of(&robot.body, &robot.start);
        // States are kept as flat arrays in the ground's frame, so that the next block continues from identical bits.
        let mut flat = self.flatten(&robot.start);
        let steps = span.first..span.first + span.steps();
        for first in steps.clone().step_by(BLOCK) {
            let block = part(first, (1..=BLOCK.min(steps.end - first)).collect());
            let seen = planned.run(vec![flat], self, &block).remove(0);
            for (k, raw) in seen.chunks_exact(size).enumerate() {
                let (of_nodes, efforts) = raw.split_at(of_nodes);
                let state = still.held(self.unflatten(of_nodes));
                let effort = span.metered.then(|| self.effort(efforts));
                if show(first + k + 1, state, effort).is_break() {
                    return;
                }
            }
            flat = seen[seen.len() - size..].to_vec();
        }
    }

    /// Describes the divergence at `node` in the last state of `last`. `seen` is the state that a policy in open loop sees, and
    /// `bound` is given if the node exceeds the speed bound.
    fn diagnose(
        &self,
        (robot, seen): (&Robot<f64>, Option<&State<f64>>),
        node: usize,
        bound: Option<Cause>,
        last: VecDeque<(usize, State<f64>)>,
    ) -> Divergence {
        let (steps, states): (Vec<usize>, Vec<State<f64>>) = last.into_iter().unzip();
        let [.., before, after] = &states[..] else {
            unreachable!("the start is never absurd, so a state precedes the absurd one")
        };
        let step = steps[steps.len() - 2];
        Divergence {
            step,
            node,
            position: after.x[node],
            velocity: after.v[node],
            term: bound
                .unwrap_or_else(|| self.blame((robot, seen.unwrap_or(before)), before, step, node)),
            last: Trajectory::new(steps, states),
        }
    }
}
