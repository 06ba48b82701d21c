//! [`Span`]: what robots do in a walk, and what is observed of it.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use autodiff_programs::{CotangentBound, Memory};

use crate::lattice::State;

/// The steps of a walk, and the states that are observed.
#[derive(Clone, Debug)]
pub struct Span {
    /// The number of steps on the clock at the start: after `n` steps of the span, the time is `(first + n) dt`.
    pub first: usize,
    /// The numbers of steps after which the state is observed, ascending. The walk ends at the last one.
    pub observed: Vec<usize>,
    /// The number of nodes in an observed state, at least one: it contains only the first `nodes` nodes.
    pub nodes: usize,
    /// If true, every state after the start is checked in a cheap way for absurd positions and too fast nodes. If a
    /// state fails this check, all observations become NaN. [`guarded`](crate::walk::guarded) relies on this.
    pub watched: bool,
    /// A bound on the cotangent in the reverse sweep; without a bound (`None`), the gradient is exact (D11). Its norm counts
    /// cotangents of velocities in units of the [time scale](crate::lattice::Lattice::time_scale).
    pub cotangent_bound: Option<CotangentBound>,
    /// If true, trajectories also have the [efforts](super::Trajectory::efforts) of the bars.
    pub metered: bool,
    /// For robots without feedback (open loop): the state in the world's frame that the policy sees in every step, in place
    /// of the current one. Only the clock that it sees advances.
    pub open_loop: Option<State<f64>>,
    /// The memory that a walk may use to store states for its reverse sweep. The gradient does not depend on it.
    pub memory: Memory,
    /// A flag that another thread may set to stop all walks. Their states and gradients are then NaN.
    pub stop: Option<Arc<AtomicBool>>,
}

impl Span {
    /// A span that begins at time 0, observes all nodes, is not watched, has feedback and exact gradients, and uses any
    /// memory.
    pub fn from_start(observed: Vec<usize>) -> Self {
        Self {
            first: 0,
            observed,
            nodes: usize::MAX,
            watched: false,
            cotangent_bound: None,
            metered: false,
            open_loop: None,
            memory: Memory::All,
            stop: None,
        }
    }

    /// A span of `steps` steps that observes only the last state.
    pub fn of_steps(steps: usize) -> Self {
        Self::from_start(vec![steps])
    }

    /// This span with these observed states.
    #[must_use]
    pub fn observing(&self, observed: Vec<usize>) -> Self {
        Self {
            observed,
            ..self.clone()
        }
    }

    /// The number of steps of the walk.
    pub fn steps(&self) -> usize {
        self.observed.last().copied().unwrap_or(0)
    }
}
