//! The kinds of operations in a step.

use super::mapped::Mapped;
use crate::arrays::{
    DenseLayer, Equations, Gather, InLanes, Layer, NodeSum, Operation, Solve, Weighted,
};
use crate::real::{Real, of_floats};

/// A recorded operation.
pub(crate) enum StepOperation {
    Kernel(Mapped),
    Gather(Gather),
    Weighted(Weighted),
    NodeSum(NodeSum),
    Solve(Equations),
    Dense(Layer),
}

impl StepOperation {
    /// Returns what carries out the operation with numbers of type `R`. With the feature `rollouts`, this crate compiles
    /// it for floats. Without it, each crate compiles the operations that it needs.
    pub(super) fn compiled<R: Real>(self) -> Box<dyn Operation<R>> {
        if const { !R::IS_FLOAT } {
            return self.any();
        }
        type Compile<R> = fn(StepOperation) -> Box<dyn Operation<R>>;
        let compile: Compile<R> =
            of_floats(Self::double as Compile<f64>, Self::single as Compile<f32>);
        compile(self)
    }

    #[cfg_attr(feature = "rollouts", inline(never))]
    #[cfg_attr(not(feature = "rollouts"), inline)]
    fn double(self) -> Box<dyn Operation<f64>> {
        self.any()
    }

    #[cfg_attr(feature = "rollouts", inline(never))]
    #[cfg_attr(not(feature = "rollouts"), inline)]
    fn single(self) -> Box<dyn Operation<f32>> {
        self.any()
    }

    fn any<R: Real>(self) -> Box<dyn Operation<R>> {
        match self {
            Self::Kernel(mapped) => mapped.compiled(),
            Self::Gather(gather) => Box::new(InLanes(gather)),
            Self::Weighted(weighted) => Box::new(InLanes(weighted)),
            Self::NodeSum(sum) => Box::new(InLanes(sum)),
            Self::Solve(equations) => Box::new(InLanes(Solve::new(equations))),
            Self::Dense(layer) => Box::new(DenseLayer::new(layer)),
        }
    }
}
