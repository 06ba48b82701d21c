//! Co-design of truss-lattice robots: structure, material and neural control optimised together by
//! gradients through a differentiable simulator.

pub mod scene;
