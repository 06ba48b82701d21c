//! The mechanical part of a step: in each substep, forces push the nodes, and the nodes move and may meet the ground.

use std::slice;
use std::sync::Arc;

use autodiff::Real;
use autodiff_programs::{Array, Fields, Graph, Program};

use super::effort::{self, BarImpulse, MeanVelocity, Meter, NodeInPush};
use super::implicit::Implicit;
use super::parameters::{MechanicsParameters, ParameterSink, StepParameters};
use crate::geometry::{Axes, Dimension, Ground, Vector};
use crate::in_dimension;
use crate::lattice::Lattice;
use crate::laws::kernels::Terrain;
use crate::laws::{
    AnyContact, Drift, FlightInputs, Force, ForceParameters, Motion, Step, StepInput, add,
};
use crate::scene::{Integrator, PhysicsSettings};

/// The forces, the contact law and the integrator of a substep of length `h = dt / substeps`.
///
/// A push changes velocities, a drift changes positions. Symplectic Euler pushes for `h` with the forces at the start,
/// then drifts for `h`. Leapfrog drifts for `h / 2`, pushes for `h` and drifts for `h / 2`, with contact in both
/// drifts. With leapfrog, half of the damping comes before the push and half after it, so the step is symmetric in time
/// and of second order.
#[derive(Clone, Debug)]
pub(crate) struct Mechanics {
    substeps: usize,
    /// The number of passes of an implicit step; `None` for an explicit integrator.
    passes: Option<usize>,
    /// The drift before the push; `None` for an integrator without one.
    first: Option<Drift>,
    /// The time for which the forces push in a substep, s.
    pub(crate) push: f64,
    /// The drift after the push.
    drift: Drift,
    /// The length of a substep, s.
    h: f64,
    /// The gravity of the scene, m/s^2.
    pub(crate) gravity: f64,
    /// The damping of the scene, 1/s.
    damping: f64,
    /// The softening of lengths, m^2.
    softening: f64,
    contact: Arc<dyn AnyContact>,
    /// The profile of the ground above the ground line; `None` if the ground is a straight line.
    terrain: Option<Terrain>,
    pub(crate) forces: Vec<Arc<dyn Force>>,
    ground: Ground,
    pub(super) dimension: Dimension,
}

/// What changes the forces from step to step, besides the state of the nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Actuation {
    /// The controller's output for each slot of the graph.
    pub(super) activation: Array,
    /// The time (s), for each node; `None` if no force needs it.
    pub(super) time: Option<Array>,
}

/// The factor by which damping (1/s) multiplies a velocity in a time `h` (s).
fn decay<R: Real>(damping: R, h: f64) -> R {
    (-damping * R::lit(h)).exp()
}

impl Mechanics {
    pub(super) fn new(lattice: &Lattice, physics: &PhysicsSettings) -> Self {
        let h = physics.dt / physics.substeps as f64;
        // Leapfrog applies half of the damping after the push. This half also reduces the velocity that the push adds.
        let (first, drift, push) = match physics.integrator {
            Integrator::SymplecticEuler | Integrator::Implicit => (None, Drift { dt: h }, h),
            Integrator::Leapfrog => {
                let half = Drift { dt: 0.5 * h };
                (Some(half), half, h * decay(physics.damping, h).sqrt())
            }
        };
        Self {
            substeps: physics.substeps,
            passes: (physics.integrator == Integrator::Implicit).then_some(physics.passes),
            first,
            push,
            drift,
            h,
            gravity: physics.gravity,
            damping: physics.damping,
            softening: lattice.softening(),
            contact: physics.contact_law().into(),
            terrain: Terrain::new(&physics.ground.resolved()),
            forces: physics.forces_on(lattice),
            ground: Ground::from(physics),
            dimension: lattice.dimension,
        }
    }

    /// The factor by which damping multiplies a velocity in a substep.
    pub(crate) fn decay(&self) -> f64 {
        decay(self.damping, self.h)
    }

    /// The velocity that gravity adds to a node in a push, m/s. `gravity` is the acceleration (m/s^2).
    pub(crate) fn fallen<R: Real>(&self, gravity: R) -> Vector<R> {
        let pushed = Vector::upright(R::zero(), -gravity * R::lit(self.push));
        self.ground.vector_to_ground(pushed)
    }

    /// True if bars pull with the forces that they have at the end of a step.
    pub(crate) fn is_implicit(&self) -> bool {
        self.passes.is_some()
    }

    /// True if a force reads the time.
    pub(super) fn needs_time(&self) -> bool {
        self.forces.iter().any(|force| force.needs_time())
    }

    /// Declares the parameters of the pushes, the contact law and the forces.
    pub(super) fn parameters<P: ParameterSink>(&self, p: &mut P) -> MechanicsParameters<P::Array> {
        let (dimension, h) = (self.dimension, self.h);
        let gravity = StepInput::new("physics.gravity", self.gravity);
        let damping = StepInput::new("physics.damping", self.damping);
        let axes = 0..dimension.count();
        let fallen = axes.map(|k| {
            let velocity = |given: &[P::Number]| vec![dimension.list(self.fallen(given[0]))[k]];
            p.of_surroundings(slice::from_ref(&gravity), velocity)
        });
        let mut push: Vec<P::Array> = fallen.collect();
        push.push(match self.first {
            // Leapfrog applies a part of the damping to impulses, so it takes it as a constant.
            Some(_) => p.shared(&[self.decay()]),
            None => p.of_surroundings(&[damping], |given| vec![decay(given[0], h)]),
        });
        let contact = self.contact.inputs().into_iter();
        let contact = contact.map(|input| p.number(input)).collect();
        let force = |force: &Arc<dyn Force>| ForceParameters {
            constants: force.constants().iter().map(|a| p.shared(a)).collect(),
            inputs: force
                .inputs()
                .into_iter()
                .map(|input| p.number(input))
                .collect(),
        };
        MechanicsParameters {
            forces: self.forces.iter().map(force).collect(),
            push,
            one: self.first.map(|_| p.shared(&[1.0])),
            contact,
        }
    }

    /// Records the mechanical part of a step and returns the nodes after it. `meter` is advanced if it is given.
    pub(super) fn record(
        &self,
        p: &mut Program,
        graph: &Graph,
        mut nodes: Motion,
        given: &StepParameters<Array>,
        Actuation { activation, time }: Actuation,
        mut meter: Option<&mut Meter>,
    ) -> Motion {
        let terrain = self.terrain.as_ref();
        let first = self.first.zip(given.mechanics.one).map(|(drift, one)| {
            let [zero, zeros] = [1, graph.nodes()].map(|n| p.gather(one, &vec![None; n]));
            (drift, [zero, zeros, one])
        });
        for _ in 0..self.substeps {
            if let Some((drift, still)) = first {
                nodes = self.drifted(p, drift, still, nodes, given);
            }
            let step = Step {
                graph,
                nodes,
                inverse_mass: given.inverse_mass,
                activation,
                stiffness: given.stiffness,
                rest_length: given.rest_length,
                strain: given.strain,
                time,
                dt: self.push,
                softening: self.softening,
                largest_strain: given.largest_strain,
                vertical: self.ground.vertical(),
            };
            if let Some(passes) = self.passes {
                let implicit = Implicit {
                    contact: &*self.contact,
                    terrain,
                    forces: &self.forces,
                    passes,
                    given,
                    step: &step,
                };
                nodes = implicit.record(p, meter.as_deref_mut());
                continue;
            }
            let mut impulses = None;
            for (force, given) in self.forces.iter().zip(&given.mechanics.forces) {
                let own = force.record(p, &step, given);
                impulses = Some(add(p, impulses, own));
            }
            let impulses = impulses.expect("every robot has springs");
            if let Some(meter) = meter.as_deref_mut() {
                *meter = self.metered(p, &step, given, impulses, *meter);
            }
            let pushed = FlightInputs {
                nodes,
                impulses,
                inverse_mass: given.inverse_mass,
                uniforms: &[&given.mechanics.push[..], &given.mechanics.contact].concat(),
            };
            nodes = self.contact.fly(p, self.drift, terrain, pushed);
        }
        nodes
    }

    /// Records a drift, which is a flight without a push. `zero` and `one` are single numbers, and `zeros` has a zero for each
    /// node.
    fn drifted(
        &self,
        p: &mut Program,
        drift: Drift,
        [zero, zeros, one]: [Array; 3],
        nodes: Motion,
        given: &StepParameters<Array>,
    ) -> Motion {
        let pushed = FlightInputs {
            nodes,
            impulses: Axes::from_fn(self.dimension, |_| zeros),
            inverse_mass: given.inverse_mass,
            uniforms: &[
                &vec![zero; self.dimension.count()],
                &[one][..],
                &given.mechanics.contact,
            ]
            .concat(),
        };
        self.contact.fly(p, drift, self.terrain.as_ref(), pushed)
    }

    /// Records the meter after an explicit push in which nodes get these impulses (N s).
    fn metered(
        &self,
        p: &mut Program,
        step: &Step,
        given: &StepParameters<Array>,
        impulses: Axes<Array>,
        before: Meter,
    ) -> Meter {
        let tension = effort::tension(p, step, &self.forces, given);
        let (dt, softening) = (step.dt, step.softening);
        in_dimension!(self.dimension, D => {
            let (positions, pulling) = (step.nodes.x.array::<D>(), BarImpulse::<D> { dt, softening });
            let pulls = p.map_each_edge(step.graph, pulling, positions, &[tension], &[]);
            let node = NodeInPush {
                v: step.nodes.v.vector::<D>(),
                impulse: impulses.vector(),
                inverse_mass: given.inverse_mass,
            };
            let moving = p.map(MeanVelocity::<D>, node.array(), &given.mechanics.push);
            before.after(p, step.graph, moving.into(), pulls.into(), tension)
        })
    }
}
