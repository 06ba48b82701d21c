//! What a rollout leaves behind.

use crate::lattice::State;

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
