//! The efforts of a robot's bars: what a rollout records besides the states of the nodes, for losses about energy and
//! forces and for the loads of implicit steps.

use std::sync::Arc;

use autodiff::{Parameters, Real};
use autodiff_programs::{Array, Compiled, Graph, Kernel, Program};

use super::parameters::StepParameters;
use crate::geometry::{Axes, Vector};
use crate::lattice::Body;
use crate::laws::{Force, Push, Step, Tensions};
use crate::{in_both_dimensions, in_dimension, kernel};

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
    /// of the bar with the first order of the time step; that of [`BarLoad`](super::BarLoad) has the second order.
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
        let per_edge = [impulse.as_slice(), &[self.work, self.net]].concat();
        let [work, net] = in_dimension!(moving.dimension(), D => {
            p.map_each_edge::<_, D, { 2 * D + 2 }, 2>(graph, Work, moving.array(), &per_edge, &[])
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
    let sum = forces
        .iter()
        .zip(&given.mechanics.forces)
        .fold(None, |sum: Option<Tensions>, (force, given)| {
            force.record_slopes(p, step, given, sum).or(sum)
        });
    sum.expect("every robot has springs").tension
}

/// The kernel of the energies of a bar (J) after a push: the energy given, and the energy given less the energy taken. The
/// inputs are the mean relative velocity of its ends (m/s), its impulse on its first node (N s) and the energies before. At
/// the kink, where the bar gives nothing, the derivative of the energy given is 0.
struct Work;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 2 * D + 2 }, 2> for Work {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, x: [R; 2 * D + 2], _: &[R]) -> [R; 2] {
            let ([dv, impulse], before) = Vector::<R, D>::split(&x);
            let given = -impulse.dot(dv);
            [before[0] + given.max(R::zero()), before[1] + given]
        }
    }
}

/// The kernel of the mean of a node's velocities before and after an explicit push (m/s), from the velocity before, the
/// impulse (N s) and 1 / mass (1/kg). The uniform inputs are those of a [`Push`].
pub(super) struct MeanVelocity;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 2 * D + 1 }, D> for MeanVelocity {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = Push::<f64, D>::COUNT;

        fn eval<R: Real>(&self, x: [R; 2 * D + 1], push: &[R]) -> [R; D] {
            let ([v, impulse], rest) = Vector::<R, D>::split(&x);
            let after = Push::of(push).velocity(v, impulse, rest[0]);
            ((v + after) * R::lit(0.5)).array()
        }
    }
}

/// The kernel of the impulse of a bar on its first node (N s), from the vector along the bar (m) and its tension (N).
pub(super) struct BarImpulse {
    /// The duration of the push, s.
    pub(super) dt: f64,
    /// The softening of lengths, m^2.
    pub(super) softening: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ D + 1 }, D> for BarImpulse {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, x: [R; D + 1], _: &[R]) -> [R; D] {
            let ([d], tension) = Vector::<R, D>::split(&x);
            let per_length = tension[0] * R::lit(self.dt) / d.softened_norm(self.softening);
            (d * per_length).array()
        }
    }
}

/// The kernel of the tension of a bar (N), from the vector along it (m) and the impulse on its first node (N s).
pub(super) struct BarTension {
    /// The duration of the push, s.
    pub(super) dt: f64,
    /// The softening of lengths, m^2.
    pub(super) softening: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 2 * D }, 1> for BarTension {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, x: [R; 2 * D], _: &[R]) -> [R; 1] {
            let ([d, impulse], _) = Vector::<R, D>::split(&x);
            [d.dot(impulse) / (d.softened_norm(self.softening) * R::lit(self.dt))]
        }
    }
}
