//! The interface of the operations in a step, once their number type is known.

use autodiff::Real;
use autodiff::simd::{Lane, Vectorized};

use super::array::Array;
use super::row::{Bars, StepValues};

/// A recorded operation. Its outputs lie in the step's row, after all arrays that the operation reads.
pub(crate) trait Operation<R: Real>: Send {
    fn outputs(&self) -> Vec<Array>;
    fn forward(&mut self, parameters: &[R], row: &mut [R]);
    /// Pulls the cotangents of the outputs back and adds them to the cotangents of the inputs.
    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>);
    /// Sets which arrays (by id) and which parameters carry derivatives, and returns whether the outputs do. An operation may
    /// skip the cotangents of all others.
    fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) -> bool;
    /// Takes the matrices of a dense layer from the parameters. Other operations have none.
    fn load(&mut self, _parameters: &[&[R]]) {}
    /// Adds the cotangent of the matrix of a dense layer to the cotangents of the parameters. Call it after the last
    /// reverse step.
    fn matrix_bars(&mut self, _parameter_bars: &mut [Vec<R>]) {}
}

/// An [`Operation`] that is written once for all lane types.
pub(crate) trait LaneOperation<R: Real>: Send {
    /// See [`Vectorized::HAS_SCALARS`].
    const HAS_SCALARS: bool = true;
    /// See [`Vectorized::HAS_512`].
    const HAS_512: bool = true;
    /// See [`Operation::outputs`].
    fn outputs(&self) -> Vec<Array>;
    /// See [`Operation::set_active`].
    fn set_active(&mut self, arrays: &[bool]) -> bool;
    /// Implements [`Operation::forward`] with lanes of type `L`. Mark it `#[inline(always)]`.
    fn forward_in<L: Lane<R>>(&mut self, parameters: &[R], row: &mut [R]);
    /// Implements [`Operation::reverse`] with lanes of type `L`. Mark it `#[inline(always)]`.
    fn reverse_in<L: Lane<R>>(&mut self, values: StepValues<R>, bars: &mut Bars<R>);
}

/// Runs a [`LaneOperation`] in the widest registers of its number type.
pub(crate) struct InLanes<T>(pub(crate) T);

impl<R: Real, T: LaneOperation<R>> Operation<R> for InLanes<T> {
    fn outputs(&self) -> Vec<Array> {
        self.0.outputs()
    }
    fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        R::vectorize(ForwardInLanes(&mut self.0, parameters, row));
    }
    fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        R::vectorize(ReverseInLanes(&mut self.0, *values, bars));
    }
    fn set_active(&mut self, arrays: &[bool], _parameters: &[bool]) -> bool {
        self.0.set_active(arrays)
    }
}

struct ForwardInLanes<'a, T, R>(&'a mut T, &'a [R], &'a mut [R]);

impl<R: Real, T: LaneOperation<R>> Vectorized<R> for ForwardInLanes<'_, T, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    const HAS_SCALARS: bool = T::HAS_SCALARS;
    const HAS_512: bool = T::HAS_512;
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        self.0.forward_in::<L>(self.1, self.2);
    }
}

struct ReverseInLanes<'a, 'b, T, R>(&'a mut T, StepValues<'a, R>, &'a mut Bars<'b, R>);

impl<R: Real, T: LaneOperation<R>> Vectorized<R> for ReverseInLanes<'_, '_, T, R> {
    const USE_THE_ATTRIBUTE_KERNEL: () = ();
    type Output = ();
    const HAS_SCALARS: bool = T::HAS_SCALARS;
    const HAS_512: bool = T::HAS_512;
    #[inline(always)]
    fn run<L: Lane<R>>(self) {
        self.0.reverse_in::<L>(self.1, self.2);
    }
}
