//! The states of a rollout.

use crate::geometry::Vector;
use crate::lattice::State;

/// Distance from the origin (m) and speed (m/s), each by components, from which on a state is
/// absurd.
pub(super) const ABSURD: f64 = 1e6;
/// Half of that, from which on a watched state is caught: it is looked at in the ground's frame,
/// which may be turned against the world's.
pub(super) const WATCHED: f64 = 0.5 * ABSURD;

/// States of a rollout in the world's frame, by the number of steps done.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory<R> {
    /// Numbers of steps done, ascending; 0 is the start.
    pub steps: Vec<usize>,
    /// The state after so many steps, one for each of `steps`.
    pub states: Vec<State<R>>,
}

impl<R> Trajectory<R> {
    /// How many steps were done at the last state.
    ///
    /// # Panics
    /// Where the trajectory is empty.
    pub fn last_step(&self) -> usize {
        *self.steps.last().expect("a trajectory holds a state")
    }

    /// The state after so many steps.
    ///
    /// # Panics
    /// Where that state was not kept: a loss states beforehand what it observes.
    pub fn at(&self, step: usize) -> &State<R> {
        match self.steps.binary_search(&step) {
            Ok(index) => &self.states[index],
            Err(_) => panic!(
                "the state after {step} steps was not kept: {:?} were",
                self.steps
            ),
        }
    }
}

impl State<f64> {
    /// The first node that is not finite, farther than 1e6 m from the origin or faster than
    /// 1e6 m/s.
    pub fn absurd_node(&self) -> Option<usize> {
        // A NaN is not below anything.
        let sane = |vector: &Vector<f64>| vector.iter().all(|c| c.abs() < ABSURD);
        let mut nodes = self.x.iter().zip(&self.v);
        nodes.position(|(x, v)| !(sane(x) && sane(v)))
    }

    /// The speed of every node, m/s.
    pub fn speeds(&self) -> impl Iterator<Item = f64> {
        self.v.iter().map(|v| v.norm())
    }

    /// The first node that is faster than a bound, m/s, and its speed.
    pub(super) fn too_fast(&self, bound: f64) -> Option<(usize, f64)> {
        let mut speeds = self.speeds().enumerate();
        speeds.find(|(_, speed)| *speed > bound)
    }

    /// Whether there is an [absurd node](State::absurd_node).
    pub fn is_absurd(&self) -> bool {
        self.absurd_node().is_some()
    }
}
