//! The efforts of a robot's bars: what a rollout records besides the states of the nodes, for losses about energy and
//! forces and for the loads of implicit steps.

use std::sync::Arc;

use autodiff::{AnyProgram, Array, Kernel, Real};

use super::parameters::Parameters;
use crate::geometry::Vector;
use crate::lattice::{Body, EdgeVector};
use crate::laws::{Force, Particle, Step, Tensions};

/// What the bars of a robot do in the step that ends at an observed state. Each list has a number for every edge. At the
/// start of a rollout all numbers are 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Effort<R> {
    /// The controller's output, from -1 to 1; 0 for an edge without an actuator.
    pub activation: Vec<R>,
    /// The force with which the bar pulled its ends together, N. With substeps, it is that of the last one. In an implicit
    /// step it is the force that the step used, which is not stiffness times elongation.
    pub tension: Vec<R>,
    /// The energy that the bar has given to its ends since the start of the rollout, J. While it takes energy from them, it
    /// counts as 0.
    pub work: Vec<R>,
}

impl<R: Copy> Effort<R> {
    /// The number of lists.
    pub(super) const LISTS: usize = 3;

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
        }
    }

    /// A copy with `f` applied to every number.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> Effort<S> {
        let each = |numbers: &[R]| numbers.iter().map(|&x| f(x)).collect();
        Effort {
            activation: each(&self.activation),
            tension: each(&self.tension),
            work: each(&self.work),
        }
    }
}

/// The efforts of a rollout, with what a loss needs to judge them.
#[derive(Clone, Debug, PartialEq)]
pub struct Efforts<R> {
    /// The efforts: one for each state of the trajectory.
    pub of_states: Vec<Effort<R>>,
    /// The robot: stiffnesses, strains and masses.
    pub body: Body<R>,
    /// The length of a step, s.
    pub dt: f64,
}

impl<R: Copy> Efforts<R> {
    /// A copy with `f` applied to every number.
    pub fn map<S>(&self, f: impl Fn(R) -> S) -> Efforts<S> {
        Efforts {
            of_states: self.of_states.iter().map(|effort| effort.map(&f)).collect(),
            body: self.body.map(&f),
            dt: self.dt,
        }
    }
}

/// The tension and the work of every bar while a step is recorded, as arrays over the slots of the graph.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meter {
    pub(super) tension: Array,
    pub(super) work: Array,
}

impl Meter {
    /// The meter after a push in which bars have this tension. The ends of the bars are at the positions of `ends` and have
    /// its velocities.
    pub(super) fn after(
        self,
        p: &mut AnyProgram,
        step: &Step,
        ends: Particle<Array>,
        tension: Array,
    ) -> Self {
        let given = Work {
            dt: step.dt,
            softening: step.softening,
        };
        let per_edge = [tension, self.work];
        let [work] = p.map_each_edge(step.graph, given, ends.array(), &per_edge, &[]);
        Self { tension, work }
    }
}

/// Records the tension of every bar in a pose: the sum over all forces along bars.
pub(super) fn tension(
    p: &mut AnyProgram,
    step: &Step,
    forces: &[Arc<dyn Force>],
    given: &Parameters<Array>,
) -> Array {
    let sum = forces
        .iter()
        .zip(&given.forces)
        .fold(None, |sum: Option<Tensions>, (force, given)| {
            force.record_slopes(p, step, given, sum).or(sum)
        });
    sum.expect("every robot has springs").tension
}

/// The kernel of the energy that a bar has given to its ends (J), after a push. The inputs are the vector along the bar
/// (m), the relative velocity of its ends (m/s), its tension (N) and the energy before. A bar that pulls gives energy while
/// it grows shorter. At the kink, where it gives nothing, the derivative is 0.
struct Work {
    /// The duration of the push, s.
    dt: f64,
    /// The softening of lengths, m^2.
    softening: f64,
}

impl Kernel<6, 1> for Work {
    #[inline(always)]
    fn eval<R: Real>(&self, [dx, dy, dvx, dvy, tension, work]: [R; 6]) -> [R; 1] {
        let edge = EdgeVector {
            d: Vector::new([dx, dy]),
            dv: Vector::new([dvx, dvy]),
        };
        let power = -tension * edge.rate(edge.length(self.softening));
        [R::lit(self.dt).fma(power.max(R::zero()), work)]
    }
}

/// The kernel of the tension of a bar (N), from the vector along it (m) and the impulse on its first node (N s).
pub(super) struct Pulled {
    /// The duration of the push, s.
    pub(super) dt: f64,
    /// The softening of lengths, m^2.
    pub(super) softening: f64,
}

impl Kernel<4, 1> for Pulled {
    #[inline(always)]
    fn eval<R: Real>(&self, [dx, dy, jx, jy]: [R; 4]) -> [R; 1] {
        let (d, impulse) = (Vector::new([dx, dy]), Vector::new([jx, jy]));
        [d.dot(impulse) / (d.softened_norm(self.softening) * R::lit(self.dt))]
    }
}
