//! The guard: finding where a rollout went wrong.
//!
//! A guarded rollout is [watched](Span::watched): it tells whether some state may be absurd. Only
//! then is the rollout done again, and every state looked at.

use std::collections::VecDeque;
use std::ops::Range;

use super::blame::Cause;
use super::rollout::{Simulator, Span};
use super::trajectory::{ABSURD, Trajectory, WATCHED};
use crate::controller::Controller;
use crate::error::Error;
use crate::lattice::{Body, State};

/// States that the search holds at a time.
const BLOCK: usize = 64;
/// States before the absurd one that are kept to look at.
const KEPT: usize = 8;

/// The first absurd state of a rollout.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// The step that produced it, from 0.
    pub step: usize,
    /// The first node that is absurd in it.
    pub node: usize,
    /// Its position in the world's frame, m.
    pub position: [f64; 2],
    /// Its velocity, m/s.
    pub velocity: [f64; 2],
    /// The term of that step that caused it.
    pub term: Cause,
    /// The last states up to the absurd one.
    pub last: Trajectory<f64>,
}

/// A rollout of which every state was looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Guarded {
    /// The observed states, bit for bit those of [`Simulator::rollout`].
    pub trajectory: Trajectory<f64>,
    /// The first absurd state, observed or not; the start is not judged.
    pub divergence: Option<Divergence>,
}

impl From<&Divergence> for Error {
    fn from(divergence: &Divergence) -> Self {
        Error::Diverged {
            step: divergence.step,
            node: divergence.node,
            position: divergence.position,
            velocity: divergence.velocity,
            term: divergence.term.to_string(),
        }
    }
}

impl Simulator {
    /// A rollout in which no absurd state goes unnoticed. Where none is, this costs a look at
    /// every number of every state beyond the plain rollout; where one is, up to two more rollouts.
    ///
    /// # Panics
    /// As [`rollout`](Simulator::rollout).
    pub fn guarded(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        start: &State<f64>,
        span: &Span,
    ) -> Guarded {
        let watched = Span {
            watched: true,
            ..span.clone()
        };
        let seen = self.rollout(body, controller, start, &watched);
        if seen.states.last().is_none_or(|last| self.is_cleared(last)) {
            return Guarded {
                trajectory: seen,
                divergence: None,
            };
        }
        let steps = span.first..span.first + span.steps();
        Guarded {
            trajectory: self.rollout(body, controller, start, span),
            divergence: self.divergence(body, controller, start, steps),
        }
    }

    /// True if a watched rollout that ends in this state surely had no absurd one. Otherwise
    /// [`guarded`](Simulator::guarded) finds out.
    pub fn is_cleared(&self, last: &State<f64>) -> bool {
        // A place within both bounds of the ground's frame is that far from its origin at most,
        // which may itself be far above the world's.
        let farthest = self.ground.height.abs() + 2f64.sqrt() * WATCHED;
        farthest < ABSURD && !last.is_absurd()
    }

    /// The first absurd state of a rollout over these of the planned steps, or `None`. The start is
    /// not checked.
    ///
    /// # Panics
    /// As [`rollout`](Simulator::rollout).
    pub fn divergence(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        start: &State<f64>,
        steps: Range<usize>,
    ) -> Option<Divergence> {
        let size = 4 * self.robot.graph.nodes();
        let planned = self.planned(body, controller, start);
        // Flat arrays in the ground's frame: the next block goes on from the same bits.
        let mut flat = self.flatten(start);
        let mut last = VecDeque::from([(steps.start, start.clone())]);
        for first in steps.clone().step_by(BLOCK) {
            let span = Span {
                first,
                ..Span::from_start((1..=BLOCK.min(steps.end - first)).collect())
            };
            let seen = planned.run(&flat, self, &span);
            for (k, raw) in seen.chunks_exact(size).enumerate() {
                let state = self.unflatten(raw);
                let absurd = state.absurd_node();
                last.push_back((first + k + 1, state));
                if let Some(node) = absurd {
                    return Some(self.diagnose(body, controller, node, last));
                }
                if last.len() > KEPT {
                    last.pop_front();
                }
            }
            flat = seen[seen.len() - size..].to_vec();
        }
        None
    }

    /// The divergence that the last states end in.
    fn diagnose(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        node: usize,
        last: VecDeque<(usize, State<f64>)>,
    ) -> Divergence {
        let (steps, states): (Vec<usize>, Vec<State<f64>>) = last.into_iter().unzip();
        let [.., before, after] = &states[..] else {
            unreachable!("an absurd state has one before it")
        };
        let step = steps[steps.len() - 2];
        Divergence {
            step,
            node,
            position: after.x[node],
            velocity: after.v[node],
            term: self.blame(body, controller, before, step, node),
            last: Trajectory { steps, states },
        }
    }
}
