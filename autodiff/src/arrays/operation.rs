//! The operations of a step.

use super::array::Array;
use super::row::{Bars, StepValues};
use crate::real::Real;

/// One recorded operation. Its outputs lie in the row after everything it reads.
pub(crate) trait Operation<R: Real>: Send {
    fn outputs(&self) -> Vec<Array>;
    fn forward(&mut self, parameters: &[R], row: &mut [R]);
    /// Pulls the outputs' cotangents back: adds to the inputs' bars.
    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>);
    /// Tells which arrays (by id) and which parameters carry derivatives; the rest may be skipped.
    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]);
    /// Takes over the matrices among the parameters (row-major).
    fn load(&mut self, _parameters: &[&[R]]) {}
    /// Adds the cotangents of matrices (row-major) after the last step of a sweep.
    fn matrix_bars(&mut self, _parameter_bars: &mut [Vec<R>]) {}
}

/// An operation's work forward, to be done in lanes.
pub(super) struct Forward<'a, T, R> {
    pub(super) map: &'a mut T,
    pub(super) parameters: &'a [R],
    pub(super) row: &'a mut [R],
}

/// An operation's work in reverse.
pub(super) struct Reverse<'a, 'b, T, R> {
    pub(super) map: &'a mut T,
    pub(super) values: &'a StepValues<'a, R>,
    pub(super) bars: &'a mut Bars<'b, R>,
}
