//! The kinds of operations in a step.

use crate::arrays::{
    Array, Bars, DenseLayer, Gather, InLanes, NodeSum, Operation, Solve, StepValues, Weighted,
};
use crate::real::Real;
use crate::record::ReplayedKernel;

/// An operation of a step. This is an enum, because a trait object would also compile the reverse sweep of every
/// operation for number types that only run forward, such as duals.
pub(crate) enum StepOperation<R: Real> {
    /// A kernel that runs in lanes.
    Kernel(Box<dyn Operation<R>>),
    /// A kernel that is recorded once and replayed.
    Replayed(ReplayedKernel),
    Gather(InLanes<Gather>),
    Weighted(InLanes<Weighted>),
    NodeSum(InLanes<NodeSum>),
    Solve(Box<InLanes<Solve<R>>>),
    Dense(Box<DenseLayer<R>>),
}

/// Evaluates an expression for the operation, whatever its kind. For operations in a box, `as_ref` or `as_mut` gives
/// access to the content.
macro_rules! each {
    ($of:expr, $open:ident, $operation:ident => $work:expr) => {
        match $of {
            StepOperation::Replayed($operation) => $work,
            StepOperation::Gather($operation) => $work,
            StepOperation::Weighted($operation) => $work,
            StepOperation::NodeSum($operation) => $work,
            StepOperation::Solve(boxed) => {
                let $operation = boxed.$open();
                $work
            }
            StepOperation::Dense(boxed) => {
                let $operation = boxed.$open();
                $work
            }
            StepOperation::Kernel(boxed) => {
                let $operation = boxed.$open();
                $work
            }
        }
    };
}

impl<R: Real> StepOperation<R> {
    /// See [`Operation::outputs`].
    pub(super) fn outputs(&self) -> Vec<Array> {
        each!(self, as_ref, of => Operation::<R>::outputs(of))
    }

    /// See [`Operation::forward`].
    pub(super) fn forward(&mut self, parameters: &[R], row: &mut [R]) {
        each!(self, as_mut, of => of.forward(parameters, row));
    }

    /// See [`Operation::reverse`].
    pub(super) fn reverse(&mut self, values: &StepValues<R>, bars: &mut Bars<R>) {
        each!(self, as_mut, of => of.reverse(values, bars));
    }

    /// See [`Operation::set_active`].
    pub(super) fn set_active(&mut self, arrays: &[bool], parameters: &[bool]) {
        each!(self, as_mut, of => Operation::<R>::set_active(of, arrays, parameters));
    }

    /// See [`DenseLayer::load`]. Does nothing for other operations.
    pub(super) fn load(&mut self, parameters: &[&[R]]) {
        if let Self::Dense(layer) = self {
            layer.load(parameters);
        }
    }

    /// See [`DenseLayer::matrix_bars`]. Does nothing for other operations.
    pub(super) fn matrix_bars(&mut self, parameter_bars: &mut [Vec<R>]) {
        if let Self::Dense(layer) = self {
            layer.matrix_bars(parameter_bars);
        }
    }
}
