//! Functions that the reverse tape takes as one entry.

use crate::real::Real;

/// A function of several slices that is differentiated as a whole.
///
/// Plain numbers and duals call [`eval`](Fused::eval). The reverse tape calls
/// [`record`](Fused::record) and, in the reverse sweep, [`reverse`](Fused::reverse), with its
/// inner number type for `R`. The three must describe the same function.
pub trait Fused: Send + 'static {
    /// What `record` keeps for `reverse`.
    type Saved<R: Real>: Send;

    /// The outputs, nothing kept.
    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R>;

    /// The outputs, and what the reverse sweep will need.
    fn record<R: Real>(&self, inputs: &[&[R]]) -> (Vec<R>, Self::Saved<R>);

    /// The cotangents of the inputs, one vector per input slice in the order of `record`. Where
    /// `wanted` is false the slice is a constant and its vector may be left empty.
    fn reverse<R: Real>(
        &self,
        saved: &mut Self::Saved<R>,
        y_bar: &[R],
        wanted: &[bool],
    ) -> Vec<Vec<R>>;
}
