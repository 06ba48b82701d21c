//! Arrays and the operations on them, forward and in reverse: kernels mapped over elements or over the edges of a
//! graph, matrix products, and gathers.
//!
//! Operations on plain floats run in SIMD lanes. Operations on duals, double-doubles or tape variables process one
//! number at a time. A [`Program`](crate::Program) is a step made of several operations. All arrays of a step, except
//! for the parameters, lie one after the other in the step's **row**. Several rollouts can run at once, each from its
//! own **start** (initial state). Their numbers are interleaved in each array.

mod fields;
mod kernel;
mod array;
mod graph;
mod row;
mod operation;
mod uniform;
pub(crate) mod dense;
mod map;
mod edges;
mod gather;
mod node_sum;
mod solve;
mod added;

pub(crate) use added::{Added, AddedArrays};
pub use added::{ArrayOperation, Forward, InputBars, InputValues, Reverse};
pub use array::{Array, Matrix, Parameter};
pub(crate) use array::{TOO_LONG, checked_sum, repeated};
pub use dense::Layer;
pub(crate) use dense::{Aligned, DenseLayer};
pub(crate) use edges::EdgeMap;
pub use fields::Fields;
pub use gather::Gather;
pub use graph::{Graph, SlotEdge};
pub use kernel::{Compiled, Kernel, MOST_UNIFORMS, Pullback, constants, pulled_back, vjp_by_duals};
pub(crate) use map::Map;
pub use node_sum::NodeSum;
pub(crate) use operation::{InLanes, Operation};
pub use row::each;
pub(crate) use row::{Bars, RowLayout, StepValues};
pub(crate) use solve::{Equations, MOST_UNKNOWNS, Solve, triangle};
pub use uniform::Fixed;
pub(crate) use uniform::assert_uniforms;
