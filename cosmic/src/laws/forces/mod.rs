//! Forces on the nodes of a lattice: the trait [`Force`], what makes a law along bars ([`OnBars`]) or on nodes
//! ([`NodeForce`]) a force, and the law of [bumpers](Bumpers), which is a force of another kind.

mod stiffness;
mod force;
mod on_bars;
mod node;
mod bumpers;

pub use bumpers::{Bump, Bumpers, Total};
pub use force::{
    AlongBars, Force, ForceParameters, LatticeForce, Pose, Pull, RestingBar, Step, Sum,
};
pub(super) use force::{AnyForce, ForceLaw, on_lattice};
pub(crate) use force::{add, tensions};
pub(super) use node::on_nodes;
pub use node::{Node, NodeForce};
pub(crate) use on_bars::OnBars;
pub(super) use on_bars::on_bars;
pub use stiffness::Stiffness;
