//! The kinds of operations in a step.

use autodiff::Real;
use autodiff::internal::of_floats;

use super::added::AddedOperation;
use super::mapped::Mapped;
use crate::arrays::{DenseLayer, Equations, Gather, InLanes, Layer, NodeSum, Operation, Solve};

/// A recorded operation.
pub enum StepOperation {
    Kernel(Mapped),
    Gather(Gather),
    NodeSum(NodeSum),
    Solve(Equations),
    Dense(Layer),
    /// An operation of another crate.
    Added(AddedOperation),
}

impl StepOperation {
    /// Returns what carries out the operation with numbers of type `R`. This crate compiles it for
    /// floats, once for all crates that have a rollout.
    pub(super) fn compiled<R: Real>(self) -> Box<dyn Operation<R>> {
        if const { !R::IS_FLOAT } {
            return self.any();
        }
        type Compile<R> = fn(StepOperation) -> Box<dyn Operation<R>>;
        let compile: Compile<R> =
            of_floats(Self::double as Compile<f64>, Self::single as Compile<f32>);
        compile(self)
    }

    #[inline(never)]
    fn double(self) -> Box<dyn Operation<f64>> {
        self.any()
    }

    #[inline(never)]
    fn single(self) -> Box<dyn Operation<f32>> {
        self.any()
    }

    fn any<R: Real>(self) -> Box<dyn Operation<R>> {
        match self {
            Self::Kernel(mapped) => mapped.compiled(),
            Self::Gather(gather) => Box::new(InLanes(gather)),
            Self::NodeSum(sum) => Box::new(InLanes(sum)),
            Self::Solve(equations) => Box::new(InLanes(Solve::new(equations))),
            Self::Dense(layer) => Box::new(DenseLayer::new(layer)),
            Self::Added(added) => added.compiled(),
        }
    }
}
