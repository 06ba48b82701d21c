//! The parts of a recorded program, for printers.

use super::operation::StepOperation;
use super::program::Program;
use crate::arrays::{Array, Parameter};

/// What a program declares and does.
#[derive(Clone, Copy)]
pub struct Parts<'a> {
    pub parameters: &'a [Parameter],
    /// The parts of the state.
    pub states: &'a [Array],
    /// For each part of the state, the array that holds its new value.
    pub next: &'a [Option<Array>],
    pub inputs: &'a [Array],
    /// How many numbers each step takes as input.
    pub inputs_len: usize,
    pub controls: &'a [Array],
    pub operations: &'a [StepOperation],
    /// How many numbers the arrays of the parameters have, and how many a row has.
    pub ends: [usize; 2],
}

impl Program {
    /// The parts of this program, which runs one start.
    ///
    /// # Panics
    /// If a part of the state was not advanced.
    #[doc(hidden)]
    #[track_caller]
    pub fn parts(&self) -> Parts<'_> {
        self.assert_advanced();
        Parts {
            parameters: &self.parameters,
            states: &self.states,
            next: &self.next,
            inputs: &self.inputs,
            inputs_len: self.inputs_len,
            controls: &self.controls,
            operations: &self.operations,
            ends: self.ends,
        }
    }
}
