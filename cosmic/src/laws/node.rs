//! Forces on every node by itself: fields, drag, pulls.

use std::sync::Arc;

use autodiff::{AnyProgram, Array, Dual, Kernel, Real};

use super::force::{AnyForce, Force, Pose, Pull, Step, add};
use super::law::Law;
use super::stiffness::Stiffness;
use crate::ground::Ground;
use crate::lattice::Lattice;
use crate::settings::Settings;

/// A node, by the numbers that the force on it may depend on; vectors are the world's.
#[derive(Clone, Copy, Debug)]
pub struct Node<R> {
    /// Position, m.
    pub x: [R; 2],
    /// Velocity, m/s.
    pub v: [R; 2],
    /// Mass, kg.
    pub mass: R,
    /// The node's own [weight](NodeForce::weight).
    pub weight: R,
    /// The time, s; 0 unless the law [asks for it](NodeForce::NEEDS_TIME).
    pub time: R,
}

/// A force on every node. To write one, give it [settings](Law) and [`force`](NodeForce::force);
/// derivatives, lanes and files follow.
///
/// Mark its methods `#[inline(always)]`: [`Kernel`] says why.
pub trait NodeForce: Law {
    /// True if [`Node::time`] is read.
    const NEEDS_TIME: bool = false;

    /// The force, N, a vector of the world. Like all generic code it selects and never branches.
    fn force<R: Real>(&self, node: Node<R>) -> [R; 2];

    /// A number of the node's own, settled before the rollout: a share, a choice of nodes, a section.
    fn weight(&self, _node: usize, _lattice: &Lattice) -> f64 {
        1.0
    }

    /// The potential energy of the node, J, of which the force is minus the slope; `None` if it has
    /// none.
    fn energy(&self, _node: Node<f64>) -> Option<f64> {
        None
    }
}

/// The impulse on a node over a step, N s, in the ground's frame: from position, velocity, 1 / mass,
/// weight and time.
#[derive(Clone, Debug)]
struct NodeKernel<L> {
    law: L,
    dt: f64,
    ground: Ground,
}

impl<L: NodeForce> Kernel<7, 2> for NodeKernel<L> {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, inverse_mass, weight, time]: [R; 7]) -> [R; 2] {
        let force = self.law.force(Node {
            x: self.ground.point_to_world([x, y]),
            v: self.ground.vector_to_world([vx, vy]),
            mass: inverse_mass.recip(),
            weight,
            time: if L::NEEDS_TIME { time } else { R::zero() },
        });
        let [fx, fy] = self.ground.vector_to_ground(force);
        [fx * R::lit(self.dt), fy * R::lit(self.dt)]
    }
}

/// A law on every node as a force.
#[derive(Clone, Debug)]
pub(crate) struct OnNodes<L> {
    pub(crate) law: L,
    /// The weights of a lattice's nodes.
    weights: Vec<f64>,
}

impl<L: NodeForce> OnNodes<L> {
    pub(crate) fn new(law: L) -> Self {
        let weights = Vec::new();
        Self { law, weights }
    }

    fn node(&self, pose: &Pose, node: usize) -> Node<f64> {
        Node {
            x: pose.state.x[node],
            v: pose.state.v[node],
            mass: pose.body.mass[node],
            weight: self.weights[node],
            time: pose.time,
        }
    }

    /// The derivatives of the force: per component those by x, y, vx and vy.
    fn slopes(&self, node: Node<f64>) -> [[f64; 4]; 2] {
        let moving = |x: [f64; 2], first: usize| [0, 1].map(|k| Dual::variable(x[k], first + k));
        let force = self.law.force(Node {
            x: moving(node.x, 0),
            v: moving(node.v, 2),
            mass: Dual::<f64, 4>::constant(node.mass),
            weight: Dual::constant(node.weight),
            time: Dual::constant(node.time),
        });
        force.map(|f| f.tangent)
    }
}

impl<L: NodeForce> AnyForce for OnNodes<L> {
    fn name(&self) -> &'static str {
        L::NAME
    }
    fn settings(&mut self) -> &mut dyn Settings {
        &mut self.law
    }
    fn boxed(&self) -> Box<dyn AnyForce> {
        Box::new(self.clone())
    }
    fn on(&self, lattice: &Lattice) -> Option<Arc<dyn Force>> {
        let nodes = 0..lattice.nodes();
        Some(Arc::new(Self {
            law: self.law.clone(),
            weights: nodes.map(|node| self.law.weight(node, lattice)).collect(),
        }))
    }
}

impl<L: NodeForce> Force for OnNodes<L> {
    fn constants(&self) -> Vec<Vec<f64>> {
        vec![self.weights.clone()]
    }

    fn needs_time(&self) -> bool {
        L::NEEDS_TIME
    }

    fn record(
        &self,
        p: &mut AnyProgram,
        step: &Step,
        constants: &[Array],
        before: Option<[Array; 2]>,
    ) -> [Array; 2] {
        let kernel = NodeKernel {
            law: self.law.clone(),
            dt: step.dt,
            ground: step.ground,
        };
        let ([x, y], [vx, vy], weight) = (step.x, step.v, constants[0]);
        let time = step.time.unwrap_or(weight);
        let impulses = p.map(kernel, [x, y, vx, vy, step.inverse_mass, weight, time]);
        add(p, before, impulses)
    }

    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        vec![Pull {
            part: L::NAME.to_owned(),
            force: self.law.force(self.node(pose, node)),
        }]
    }

    fn energy(&self, pose: &Pose) -> Option<f64> {
        let nodes = 0..pose.lattice.nodes();
        nodes
            .map(|node| self.law.energy(self.node(pose, node)))
            .sum()
    }

    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        for node in 0..pose.lattice.nodes() {
            let [[xx, xy, vxx, vxy], [yx, yy, vyx, vyy]] = self.slopes(self.node(pose, node));
            stiffness.node(node, [[-xx, -xy], [-yx, -yy]]);
            // The norm over rows bounds every eigenvalue.
            let largest = (vxx.abs() + vxy.abs()).max(vyx.abs() + vyy.abs());
            stiffness.dampen_node(node, largest);
        }
    }
}
