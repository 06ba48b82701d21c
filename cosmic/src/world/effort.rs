//! The efforts of a robot's bars: what a rollout records besides the states of the nodes, for losses about energy and
//! forces and for the loads of implicit steps.

use std::sync::Arc;

use autodiff::{Parameters, Real};
use autodiff_programs::{Array, Compiled, Graph, Kernel, Program};

use super::parameters::StepParameters;
use crate::geometry::{Axes, Vector};
use crate::lattice::Body;
use crate::laws::kernels::Push;
use crate::laws::{Force, Step, tensions};
use crate::{Fields, in_both_dimensions, in_dimension, kernel};

/// What the bars of a robot do in the step that ends at an observed state. Each list has a number for every edge. At the
/// start of a rollout all numbers are 0.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Effort<R> {
    /// The controller's output, from -1 to 1; 0 for an edge without an actuator.
    pub activation: Vec<R>,
    /// The force with which the bar pulled its ends together, N. With substeps, it is that of the last one. In an implicit
    /// step it is the force that the step used, which is not stiffness times elongation.
    pub tension: Vec<R>,
    /// The energy that the bar has given to its ends since the start of the rollout, J. While it takes energy from them, it
    /// counts as 0. The energies of all forces of a step add up to the change of the kinetic energy. They approach the work
    /// of the bar with the first order of the time step; that of [`BarLoad`](crate::walk::BarLoad) has the second order.
    pub work: Vec<R>,
    /// The energy that the bar has given to its ends since the start of the rollout less the energy that it has taken from
    /// them, J.
    pub net: Vec<R>,
}

impl<R: Copy> Effort<R> {
    /// The number of lists.
    pub(super) const LISTS: usize = 4;

    /// Reads the lists from arrays over the slots of a graph, one after the other.
    pub(super) fn of_slots(numbers: &[R], slot_of_edge: &[usize]) -> Self {
        let slots = numbers.len() / Self::LISTS;
        let list = |k: usize| {
            slot_of_edge
                .iter()
                .map(|slot| numbers[k * slots + slot])
                .collect()
        };
        Self {
            activation: list(0),
            tension: list(1),
            work: list(2),
            net: list(3),
        }
    }
}

/// The efforts of a rollout, with what a loss needs to judge them.
#[derive(Clone, Debug, PartialEq, Parameters)]
pub struct Efforts<R> {
    /// The efforts: one for each state of the trajectory.
    pub of_states: Vec<Effort<R>>,
    /// The robot: stiffnesses, strains and masses.
    pub body: Body<R>,
    /// The length of a step, s.
    pub dt: f64,
}

/// The efforts of every bar while a step is recorded, as arrays over the slots of the graph.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meter {
    pub(super) tension: Array,
    pub(super) work: Array,
    pub(super) net: Array,
}

impl Meter {
    /// The meter after a push in which bars have this tension and give these impulses to their first nodes (N s). `moving`
    /// is the mean of the velocities of the nodes before and after the push.
    ///
    /// An impulse changes the kinetic energy of a node by its product with this mean. So the works of all impulses of a push
    /// add up to the change of the kinetic energy, except for rounding.
    pub(super) fn after(
        self,
        p: &mut Program,
        graph: &Graph,
        moving: Axes<Array>,
        impulse: Axes<Array>,
        tension: Array,
    ) -> Self {
        let Self { work, net, .. } = self;
        let Energies { work, net } = in_dimension!(moving.dimension(), D => {
            let pushed = PushedBar { impulse: impulse.vector::<D>(), before: Energies { work, net } };
            let ends = moving.array::<D>();
            Energies::of(p.map_each_edge(graph, Work::<D>, ends, &pushed.list(), &[]))
        });
        Self { tension, work, net }
    }
}

/// Records the tension of every bar in a pose: the sum over all forces along bars.
pub(super) fn tension(
    p: &mut Program,
    step: &Step,
    forces: &[Arc<dyn Force>],
    given: &StepParameters<Array>,
) -> Array {
    tensions(p, step, forces, &given.mechanics.forces).tension
}

/// The energies of a bar: see [`Effort`].
#[derive(Clone, Copy, Fields)]
struct Energies<T> {
    /// The energy given, J.
    work: T,
    /// The energy given less the energy taken, J.
    net: T,
}

/// What a push does to a bar.
#[derive(Clone, Copy, Fields)]
struct PushedBar<T, const D: usize> {
    /// The impulse on its first node, N s.
    impulse: Vector<T, D>,
    before: Energies<T>,
}

/// A bar in a push.
#[derive(Clone, Copy, Fields)]
struct MovingPushedBar<T, const D: usize> {
    /// The mean relative velocity of its ends, m/s.
    dv: Vector<T, D>,
    pushed: PushedBar<T, D>,
}

/// The kernel of the energies of a bar after a push. At the kink, where the bar gives nothing, the derivative of the energy
/// given is 0.
struct Work<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for Work<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, bar: MovingPushedBar<R, D>, _: &[R]) -> Energies<R> {
            let PushedBar { impulse, before } = bar.pushed;
            let given = -impulse.dot(bar.dv);
            Energies { work: before.work + given.max(R::zero()), net: before.net + given }
        }
    }
}

/// The kernel of the mean of a node's velocities before and after an explicit push, m/s. The uniform inputs are those of a
/// [`Push`].
pub(super) struct MeanVelocity<const D: usize>;

/// A node in a push.
#[derive(Clone, Copy, Fields)]
pub(super) struct NodeInPush<T, const D: usize> {
    /// The velocity before the push, m/s.
    pub(super) v: Vector<T, D>,
    /// The impulse, N s.
    pub(super) impulse: Vector<T, D>,
    /// 1 / mass, 1/kg.
    pub(super) inverse_mass: T,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for MeanVelocity<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = Push::<f64, D>::COUNT;

        fn eval<R: Real>(&self, node: NodeInPush<R, D>, push: &[R]) -> Vector<R, D> {
            let after = Push::of(push).velocity(node.v, node.impulse, node.inverse_mass);
            (node.v + after) * R::lit(0.5)
        }
    }
}

/// A bar that pulls.
#[derive(Clone, Copy, Fields)]
pub(super) struct PullingBar<T, const D: usize> {
    /// The vector along the bar, m.
    d: Vector<T, D>,
    /// The tension, N.
    tension: T,
}

/// The kernel of the impulse of a bar on its first node, N s.
pub(super) struct BarImpulse<const D: usize> {
    /// The duration of the push, s.
    pub(super) dt: f64,
    /// The softening of lengths, m^2.
    pub(super) softening: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for BarImpulse<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, PullingBar { d, tension }: PullingBar<R, D>, _: &[R]) -> Vector<R, D> {
            let per_length = tension * R::lit(self.dt) / d.softened_norm(self.softening);
            d * per_length
        }
    }
}

/// A bar with the impulse that it gives to its first node.
#[derive(Clone, Copy, Fields)]
pub(super) struct PulledBar<T, const D: usize> {
    /// The vector along the bar, m.
    d: Vector<T, D>,
    /// The impulse, N s.
    impulse: Vector<T, D>,
}

/// The kernel of the tension of a bar, N.
pub(super) struct BarTension<const D: usize> {
    /// The duration of the push, s.
    pub(super) dt: f64,
    /// The softening of lengths, m^2.
    pub(super) softening: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for BarTension<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, PulledBar { d, impulse }: PulledBar<R, D>, _: &[R]) -> R {
            d.dot(impulse) / (d.softened_norm(self.softening) * R::lit(self.dt))
        }
    }
}
