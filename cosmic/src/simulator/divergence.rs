//! Finding where a rollout went wrong.
//!
//! The rollout itself has no guard: it costs nothing as long as all is well. Whoever finds a
//! state that [is absurd](State::is_absurd) asks here, and the rollout is done again.

use super::{Simulator, Span, Trajectory};
use crate::controller::Controller;
use crate::error::Error;
use crate::lattice::State;
use crate::projection::Body;

/// Steps that the first, coarse search goes at a time.
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
    /// The last states up to the absurd one.
    pub last: Trajectory<f64>,
}

impl From<&Divergence> for Error {
    fn from(divergence: &Divergence) -> Self {
        let Divergence {
            step,
            node,
            position,
            velocity,
            ..
        } = *divergence;
        Error::Diverged {
            step,
            node,
            position,
            velocity,
        }
    }
}

impl State<f64> {
    /// The first node that is not finite, farther than 1e6 m from the origin or faster than
    /// 1e6 m/s.
    pub fn absurd_node(&self) -> Option<usize> {
        // A NaN is not below anything.
        let sane = |point: &[f64; 2]| point.iter().all(|c| c.abs() < 1e6);
        let mut nodes = self.x.iter().zip(&self.v);
        nodes.position(|(x, v)| !(sane(x) && sane(v)))
    }

    /// Whether there is an [absurd node](State::absurd_node).
    pub fn is_absurd(&self) -> bool {
        self.absurd_node().is_some()
    }
}

impl Simulator {
    /// The first absurd state of a rollout of so many steps, or `None` where all is well. States
    /// are looked at every 64 steps and after the last: a robot that was absurd for a moment
    /// between two of them is let through. The start is not judged.
    ///
    /// # Panics
    /// As [`rollout`](Simulator::rollout).
    pub fn divergence(
        &self,
        robot: (&Body<f64>, &Controller<f64>),
        start: &State<f64>,
        steps: usize,
    ) -> Option<Divergence> {
        let mut coarse: Vec<usize> = (BLOCK..steps).step_by(BLOCK).collect();
        coarse.push(steps);
        let (reached, _) = self.first_absurd(robot, start, coarse)?;
        // From the start again, not from a state in between: its bits are the same only so.
        let first = reached.saturating_sub(BLOCK + KEPT).max(1);
        let (reached, seen) = self.first_absurd(robot, start, (first..=reached).collect())?;
        let state = seen.at(reached);
        let node = state.absurd_node()?;
        Some(Divergence {
            step: reached - 1,
            node,
            position: state.x[node],
            velocity: state.v[node],
            last: last_states(&seen, reached),
        })
    }

    /// The first of the observed numbers of steps at which the state is absurd.
    fn first_absurd(
        &self,
        robot: (&Body<f64>, &Controller<f64>),
        start: &State<f64>,
        observed: Vec<usize>,
    ) -> Option<(usize, Trajectory<f64>)> {
        let seen = self.rollout(robot, start, &Span::from_start(observed));
        let index = seen.states.iter().position(State::is_absurd)?;
        let reached = seen.steps[index];
        (reached > 0).then_some((reached, seen))
    }
}

/// The state after so many steps and the few before it.
fn last_states(seen: &Trajectory<f64>, reached: usize) -> Trajectory<f64> {
    let kept = |step: &usize| *step <= reached && step + KEPT >= reached;
    let pairs = seen.steps.iter().zip(&seen.states);
    let (steps, states) = pairs
        .filter(|(step, _)| kept(step))
        .map(|(&step, state)| (step, state.clone()))
        .unzip();
    Trajectory { steps, states }
}
