//! Finds the step in which the reverse sweep of a rollout overflows.
//!
//! If a motion amplifies small changes, cotangents grow from step to step of the reverse sweep. After thousands of
//! steps they may exceed the range of an f64 although every state is finite. The sweep itself does not check for
//! overflow. If a gradient is infinite or NaN, this module repeats the sweep: first in blocks of steps, then step by
//! step through the block in which the cotangent overflows.

use std::ops::Range;

use autodiff::{Tape, Var};

use super::plan::{Planned, Robots};
use super::prepare::{Simulator, Span};
use crate::lattice::{Body, State};
use crate::policy::Controller;

/// The number of steps of a block.
const BLOCK: usize = 64;

/// The step of a reverse sweep that makes the cotangent of the state infinite or NaN. Its text is part of a message.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the reverse sweep overflows in step {step}, first at node {node}, although the cotangents after \
     that step are at most {largest:.1e}"
)]
pub struct Overflow {
    /// The step, counted from 0. The cotangent of the state after the step is finite; the cotangent of the state before
    /// it is not.
    pub step: usize,
    /// The first node whose position or velocity has an infinite or NaN cotangent.
    pub node: usize,
    /// The largest absolute value in the cotangent of the state after the step.
    pub largest: f64,
}

impl Simulator {
    /// Repeats a reverse sweep and finds the step in which it overflows; `None` if it stays finite. The sweep starts
    /// with the derivative of the payload's position along the ground after `steps` steps. The search costs about as
    /// much as the gradient.
    ///
    /// # Panics
    /// Like [`rollout`](Simulator::rollout).
    pub fn overflow(
        &self,
        body: &Body<f64>,
        controller: &Controller<f64>,
        start: &State<f64>,
        steps: usize,
    ) -> Option<Overflow> {
        let sweep = Sweep::new(self, body, controller, start);
        let start = self.flatten(start);
        let mut bar = vec![0.0; start.len()];
        // The first number of a state is the payload's position along the ground.
        bar[0] = 1.0;
        sweep.back(&start, 0..steps, BLOCK, &mut bar)
    }
}

/// Repeats the reverse sweep of a rollout in parts. States and cotangents are flat arrays in the ground's frame, so
/// that each part continues from identical bits.
pub struct Sweep<'a> {
    simulator: &'a Simulator,
    planned: Planned<f64>,
}

impl<'a> Sweep<'a> {
    /// Prepares the sweep of a robot.
    pub fn new(
        simulator: &'a Simulator,
        body: &Body<f64>,
        controller: &Controller<f64>,
        start: &State<f64>,
    ) -> Self {
        let surroundings = simulator.surroundings();
        let robot = Robots::one(&surroundings, body, controller);
        Self {
            simulator,
            planned: simulator.planned(&robot, &[start], false),
        }
    }

    /// Sweeps back over the range `steps`. At first, `bar` is the cotangent of the state after these steps; at the end,
    /// it is the cotangent of `state`, the state before them. The sweep has parts of `part` steps. A part that
    /// overflows is repeated step by step. Returns the first overflow, if any.
    fn back(
        &self,
        state: &[f64],
        steps: Range<usize>,
        part: usize,
        bar: &mut Vec<f64>,
    ) -> Option<Overflow> {
        let firsts: Vec<usize> = steps.clone().step_by(part).collect();
        let done = firsts.iter().map(|first| first - steps.start).collect();
        let states = self.run(state, steps.start, done);
        for (&first, state) in firsts.iter().zip(states.chunks_exact(state.len())).rev() {
            let of_part = first..steps.end.min(first + part);
            let before = self.pullback(state, of_part.clone(), bar);
            match self.lost_node(&before) {
                None => *bar = before,
                Some(_) if part > 1 => return self.back(state, of_part, 1, bar),
                Some(node) => {
                    let largest = bar.iter().fold(0.0, |most: f64, c| most.max(c.abs()));
                    return Some(Overflow {
                        step: first,
                        node,
                        largest,
                    });
                }
            }
        }
        None
    }

    /// Simulates from `state`, which is the state before step `first`. Returns the states after the numbers of steps in
    /// `done`, as one list.
    pub fn run(&self, state: &[f64], first: usize, done: Vec<usize>) -> Vec<f64> {
        let span = Span {
            first,
            ..Span::from_start(done)
        };
        let starts = vec![state.to_vec()];
        self.planned.run(starts, self.simulator, &span).remove(0)
    }

    /// Computes the cotangent of `state`, the state before the steps, from the cotangent `bar` of the state after them.
    pub fn pullback(&self, state: &[f64], steps: Range<usize>, bar: &[f64]) -> Vec<f64> {
        let span = Span {
            first: steps.start,
            ..Span::from_start(vec![steps.len()])
        };
        let constant = |numbers: &Vec<f64>| numbers.iter().map(|&x| Var::constant(x)).collect();
        let constants = |lists: &Vec<Vec<f64>>| lists.iter().map(constant).collect();
        let planned = Planned {
            model: self.planned.model.clone(),
            numbers: self.planned.numbers.iter().map(constants).collect(),
        };
        let mut tape = Tape::new();
        let last = tape.record(state, |state| {
            let starts = vec![state.to_vec()];
            planned.run(starts, self.simulator, &span).remove(0)
        });
        tape.pullback(&last, bar).to_vec()
    }

    /// The first node for which the cotangent of its position or velocity is infinite or NaN.
    pub fn lost_node(&self, bar: &[f64]) -> Option<usize> {
        let nodes = self.simulator.lattice.nodes();
        let is_lost = |node: &usize| (0..4).any(|k| !bar[k * nodes + node].is_finite());
        (0..nodes).find(is_lost)
    }
}
