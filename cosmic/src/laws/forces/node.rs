//! Force laws on single nodes, such as fields and drag.

use std::sync::Arc;

use autodiff::{Dual, Real};
use autodiff_programs::{Array, Compiled, Kernel, Program};

use super::force::{AnyForce, Force, ForceLaw, ForceParameters, Pose, Pull, Step};
use super::stiffness::Stiffness;
use crate::geometry::{Axes, Matrix, Vector, explicit_in};
use crate::lattice::Lattice;
use crate::laws::law::{Law, StepInput, step_inputs};
use crate::laws::motion::Particle;
use crate::{Fields, in_both_dimensions, in_dimension, kernel};

/// A node as a law sees it: the numbers that the force may depend on. Vectors are in the ground's frame: the first
/// component is along the ground, the last component points out of it.
#[derive(Clone, Copy, Debug)]
pub struct Node<R, const D: usize = 3> {
    /// Position, m.
    pub x: Vector<R, D>,
    /// Velocity, m/s.
    pub v: Vector<R, D>,
    /// Mass, kg.
    pub mass: R,
    /// The [weight](NodeForce::weight) that the law has given this node.
    pub weight: R,
    /// The time, s; 0 unless the law [asks for it](NodeForce::NEEDS_TIME).
    pub time: R,
    /// The unit vector opposite to gravity: on level ground it points up.
    pub vertical: Vector<R, D>,
}

/// A law for the force on each node. To write a law, give it [settings](Law) and [`force`](NodeForce::force).
/// Derivatives, SIMD lanes and file formats need no further code.
///
/// The `impl` needs the attribute [`kernel`](macro@crate::kernel), and so do functions that the methods call.
pub trait NodeForce: Law {
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();

    /// True if [`force`](NodeForce::force) reads [`Node::time`].
    const NEEDS_TIME: bool = false;

    /// Computes the force on a node, N, in the ground's frame. `law` has the settings as numbers of the type `R`. The
    /// method must not branch on a [`Real`]; use `R::select` instead.
    fn force<R: Real, const D: usize>(law: &Self::Of<R>, node: Node<R, D>) -> Vector<R, D>;

    /// A constant number that the law gives a node, such as 1 for the nodes that the force acts on and 0 for the others.
    fn weight(&self, _node: usize, _lattice: &Lattice) -> f64 {
        1.0
    }

    /// The potential energy of the node, J. The force is its negative gradient. `None` if the law has no potential
    /// energy.
    fn energy<const D: usize>(&self, _node: Node<f64, D>) -> Option<f64> {
        None
    }
}

/// A node while a step is computed.
#[derive(Clone, Copy, Fields)]
struct WeighedNode<T, const D: usize> {
    node: Particle<T, D>,
    /// 1 / mass, 1/kg.
    inverse_mass: T,
    /// See [`Node::weight`].
    weight: T,
    /// The time, s; any number if the law does not need it.
    time: T,
}

/// The kernel of a law on nodes: the impulse (N s) on a node over a step.
#[derive(Clone, Debug)]
struct NodeKernel<L, const D: usize> {
    law: L,
    dt: f64,
    vertical: Vector<f64>,
}

impl<L: NodeForce, const D: usize> NodeKernel<L, D> {
    #[inline(always)]
    fn impulse<R: Real>(&self, node: WeighedNode<R, D>, settings: &[R]) -> Vector<R, D> {
        let Particle { x, v } = node.node;
        let node = Node {
            x,
            v,
            mass: node.inverse_mass.recip(),
            weight: node.weight,
            time: if L::NEEDS_TIME { node.time } else { R::zero() },
            vertical: Vector::upright(R::lit(self.vertical.forward()), R::lit(self.vertical.up())),
        };
        let force: Vector<R, D> = L::force(&self.law.of(settings), node);
        force * R::lit(self.dt)
    }
}

in_both_dimensions! { D =>
    #[kernel]
    impl<L: NodeForce> Kernel<_, _> for NodeKernel<L, D> {
        const COMPILED: Compiled = L::COMPILED.at_most(explicit_in(D));
        const UNIFORMS: usize = L::COUNT;

        fn eval<R: Real>(&self, node: WeighedNode<R, D>, settings: &[R]) -> Vector<R, D> {
            self.impulse(node, settings)
        }
    }
}

/// A law on nodes, as a [`Force`].
#[derive(Clone, Debug)]
struct OnNodes<L> {
    law: L,
    /// The weight of every node.
    weights: Vec<f64>,
}

/// A law for a force on single nodes.
pub(crate) fn on_nodes<L: NodeForce>() -> Box<dyn AnyForce> {
    ForceLaw::<L>::boxed(|law, lattice| {
        let nodes = 0..lattice.nodes();
        Some(Arc::new(OnNodes {
            law: law.clone(),
            weights: nodes.map(|node| law.weight(node, lattice)).collect(),
        }))
    })
}

impl<L: NodeForce> OnNodes<L> {
    fn node(&self, pose: &Pose, node: usize) -> Node<f64> {
        Node {
            x: pose.state.x[node],
            v: pose.state.v[node],
            mass: pose.body.mass[node],
            weight: self.weights[node],
            time: pose.time,
            vertical: pose.vertical,
        }
    }

    /// The rate at which the force changes if the position changes at the rate `dx` and the velocity at the rate `dv`.
    fn slope(&self, node: Node<f64>, dx: Vector<f64>, dv: Vector<f64>) -> Vector<f64> {
        let moving = |x: Vector<f64>, rate: Vector<f64>| {
            x.zip_with(rate, |value, rate| Dual {
                value,
                tangent: [rate],
            })
        };
        let node = Node {
            x: moving(node.x, dx),
            v: moving(node.v, dv),
            mass: Dual::<f64, 1>::constant(node.mass),
            weight: Dual::constant(node.weight),
            time: Dual::constant(node.time),
            vertical: node.vertical.map(Dual::constant),
        };
        let force = L::force(&self.law.constant::<Dual<f64, 1>>(), node);
        force.map(|f| f.tangent[0])
    }
}

impl<L: NodeForce> Force for OnNodes<L> {
    fn constants(&self) -> Vec<Vec<f64>> {
        vec![self.weights.clone()]
    }

    fn inputs(&self) -> Vec<StepInput> {
        step_inputs(&self.law)
    }

    fn needs_time(&self) -> bool {
        L::NEEDS_TIME
    }

    fn record(&self, p: &mut Program, step: &Step, given: &ForceParameters<Array>) -> Axes<Array> {
        let weight = given.constants[0];
        in_dimension!(step.dimension(), D => {
            let kernel = NodeKernel::<L, D> {
                law: self.law.clone(),
                dt: step.dt,
                vertical: step.vertical,
            };
            let node = WeighedNode {
                node: step.nodes.particle::<D>(),
                inverse_mass: step.inverse_mass,
                weight,
                time: step.time.unwrap_or(weight),
            };
            p.map(kernel, node.array(), &given.inputs).into()
        })
    }

    fn pulls(&self, pose: &Pose, node: usize) -> Vec<Pull> {
        vec![Pull {
            part: L::NAME.to_owned(),
            force: L::force(&self.law, self.node(pose, node)),
        }]
    }

    fn energy(&self, pose: &Pose) -> Option<f64> {
        let nodes = 0..pose.lattice.nodes();
        nodes
            .map(|node| self.law.energy(self.node(pose, node)))
            .sum()
    }

    fn stiffen(&self, pose: &Pose, stiffness: &mut Stiffness) {
        let zero = Vector::zero();
        for node in 0..pose.lattice.nodes() {
            let at = self.node(pose, node);
            // A planar robot does not move across.
            let axes = Vector::axes().map(|axis| pose.lattice.dimension.onto(axis));
            let by_place = axes.map(|axis| -self.slope(at, axis, zero));
            stiffness.node(node, Matrix::symmetric(by_place));
            // The largest row sum of absolute values is a bound on every eigenvalue of the matrix.
            let by_velocity = axes.map(|axis| self.slope(at, zero, axis).map(f64::abs));
            let largest = by_velocity.into_iter().sum::<Vector<f64>>().largest();
            stiffness.dampen_node(node, largest);
        }
    }
}
