//! Functions that the reverse tape takes as one entry.

use crate::forward::Dual;
use crate::real::Real;

/// A function of several slices that is differentiated as a whole.
///
/// Plain numbers call [`eval`](Fused::eval), duals [`forward`](Fused::forward). The reverse tape
/// calls [`record`](Fused::record) and, once in each reverse sweep that reaches it,
/// [`reverse`](Fused::reverse), with its inner number type for `R`. All of them must describe the
/// same function. A function with one output and known partials is shorter as a
/// [`Rule`](crate::custom::Rule).
pub trait Fused: Send + 'static {
    /// What `record` keeps for `reverse`.
    type Saved<R: Real>: Send;

    /// The outputs, nothing kept.
    fn eval<R: Real>(&self, inputs: &[&[R]]) -> Vec<R>;

    /// The outputs with their tangents. Duals through `eval` do; a function whose derivative is
    /// not that of its `eval` overrides this.
    fn forward<R: Real, const N: usize>(&self, inputs: &[&[Dual<R, N>]]) -> Vec<Dual<R, N>> {
        self.eval(inputs)
    }

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
