//! The operations of a step.

use super::array::Array;
use super::row::{Bars, StepValues};
use crate::real::Real;

/// A recorded operation. Its outputs come in the row after everything that it reads.
pub(crate) trait Operation<R: Real>: Send {
    fn outputs(&self) -> Vec<Array>;
    fn forward(&mut self, parameters: &[R], row: &mut [R]);
    /// Pulls the cotangents of the outputs back and adds them to those of the inputs.
    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>);
    /// Sets which arrays (by id) and which parameters carry derivatives. Others may be skipped.
    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]);
}

/// The forward work of an operation, done in lanes.
pub(super) struct Forward<'a, T, R> {
    pub(super) map: &'a mut T,
    pub(super) parameters: &'a [R],
    pub(super) row: &'a mut [R],
}

/// The reverse work of an operation, done in lanes.
pub(super) struct Reverse<'a, 'b, T, R> {
    pub(super) map: &'a mut T,
    pub(super) values: &'a StepValues<'a, R>,
    pub(super) bars: &'a mut Bars<'b, R>,
}
