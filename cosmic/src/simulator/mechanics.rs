//! The mechanical part of a step: in each substep, forces push the nodes, and the nodes move and may meet the ground.

use std::sync::Arc;

use autodiff::{Array, Graph, Program, Real};

use super::effort::{self, BarImpulse, MeanVelocity, Meter};
use super::implicit::Implicit;
use super::parameters::{ParameterSink, Parameters};
use super::surroundings::Surroundings;
use crate::geometry::{Ground, Vector};
use crate::lattice::Lattice;
use crate::laws::{
    AnyContact, Drift, Flight, FlightInputs, Force, ForceParameters, Particle, Step, StepInput,
    Terrain, add,
};
use crate::scene::{Integrator, PhysicsSettings};

/// The forces, the contact law and the integrator of a substep of length `h = dt / substeps`.
///
/// A push changes velocities, a drift changes positions. Symplectic Euler pushes for `h` with the forces at the start,
/// then drifts for `h`. Leapfrog drifts for `h / 2`, pushes for `h` and drifts for `h / 2`, with contact in both
/// drifts. With leapfrog, half of the damping comes before the push and half after it, so the step is symmetric in time
/// and of second order.
#[derive(Clone, Debug)]
pub(super) struct Mechanics {
    substeps: usize,
    /// The number of passes of an implicit step; `None` for an explicit integrator.
    passes: Option<usize>,
    /// The drift before the push; `None` for an integrator without one.
    first: Option<Drift>,
    /// The time for which the forces push in a substep, s.
    pub(super) push: f64,
    /// The softening of lengths, m^2.
    softening: f64,
    pub(super) flight: Flight,
    contact: Arc<dyn AnyContact>,
    /// The profile of the ground above the ground line; `None` if the ground is a straight line.
    terrain: Option<Terrain>,
    pub(super) forces: Vec<Arc<dyn Force>>,
    ground: Ground,
    /// Gravity (m/s^2), then the settings of the contact law, then the settings of each force.
    pub(super) inputs: Arc<[StepInput]>,
}

/// What changes the forces from step to step, besides the state of the nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Actuation {
    /// The controller's output for each slot of the graph.
    pub(super) activation: Array,
    /// The time (s), for each node; `None` if no force needs it.
    pub(super) time: Option<Array>,
}

impl Mechanics {
    pub(super) fn new(lattice: &Lattice, physics: &PhysicsSettings) -> Self {
        let h = physics.dt / physics.substeps as f64;
        let decay = (-physics.damping * h).exp();
        // Leapfrog applies half of the damping after the push. This half also reduces the velocity that the push adds.
        let (first, drift, push) = match physics.integrator {
            Integrator::SymplecticEuler | Integrator::Implicit => (None, Drift { dt: h }, h),
            Integrator::Leapfrog => {
                let half = Drift { dt: 0.5 * h };
                (Some(half), half, h * decay.sqrt())
            }
        };
        let mechanics = Self {
            substeps: physics.substeps,
            passes: (physics.integrator == Integrator::Implicit).then_some(physics.passes),
            first,
            push,
            softening: lattice.softening(),
            flight: Flight { drift, decay },
            contact: physics.contact_law().into(),
            terrain: Terrain::new(&physics.ground.resolved()),
            forces: physics.forces_on(lattice),
            ground: Ground::from(physics),
            inputs: Arc::new([]),
        };
        mechanics.with_inputs(physics.gravity)
    }

    /// The velocity that gravity adds to a node in a push, m/s. `gravity` is the acceleration (m/s^2).
    pub(super) fn gravity<R: Real>(&self, gravity: R) -> Vector<R> {
        let pushed = Vector::upright(R::zero(), -gravity * R::lit(self.push));
        self.ground.vector_to_ground(pushed)
    }

    /// The point of the ground from which positions are measured, in the ground's frame, from the world's origin, m.
    pub(super) fn origin(&self) -> Vector<f64> {
        self.ground.vertical() * self.ground.height
    }

    fn with_inputs(self, gravity: f64) -> Self {
        let gravity = StepInput {
            name: "physics.gravity".to_owned(),
            value: gravity,
        };
        let of_forces = self.forces.iter().flat_map(|force| force.inputs());
        let of_laws = self.contact.inputs().into_iter().chain(of_forces);
        Self {
            inputs: [gravity].into_iter().chain(of_laws).collect(),
            ..self
        }
    }

    /// The same mechanics with another coefficient of friction.
    pub(super) fn with_friction(&self, friction: f64) -> Self {
        Self {
            contact: self.contact.with_friction(friction).into(),
            ..self.clone()
        }
        .with_inputs(self.inputs[0].value)
    }

    /// True if a force reads the time.
    pub(super) fn needs_time(&self) -> bool {
        self.forces.iter().any(|force| force.needs_time())
    }

    /// Declares the parameters of the contact law and of the forces, in the order of [`inputs`](Mechanics::inputs).
    pub(super) fn parameters<P: ParameterSink>(
        &self,
        p: &mut P,
    ) -> (Vec<P::Array>, Vec<ForceParameters<P::Array>>) {
        let velocity = |s: &Surroundings<P::Number>| self.gravity(s.numbers[0]);
        let axes = [0, 1].map(|axis| p.of_surroundings(|s| [velocity(s)[axis]]));
        let mut place = 0;
        let mut next = |p: &mut P| {
            place += 1;
            p.of_surroundings(|s| [s.numbers[place]])
        };
        let of_contact = self.contact.inputs().into_iter().map(|_| next(p));
        let contact = axes.into_iter().chain(of_contact).collect();
        let force = |force: &Arc<dyn Force>| ForceParameters {
            constants: force.constants().iter().map(|a| p.shared(a)).collect(),
            inputs: force.inputs().iter().map(|_| next(p)).collect(),
        };
        (contact, self.forces.iter().map(force).collect())
    }

    /// Records the mechanical part of a step and returns the nodes after it. `meter` is advanced if it is given.
    pub(super) fn record(
        &self,
        p: &mut Program,
        graph: &Graph,
        mut nodes: Particle<Array>,
        given: &Parameters<Array>,
        Actuation { activation, time }: Actuation,
        mut meter: Option<&mut Meter>,
    ) -> Particle<Array> {
        let terrain = self.terrain.as_ref();
        let first = self.first.map(|drift| {
            let zeros = |n| p.gather(given.contact[0], &vec![None; n]);
            (drift, [1, graph.nodes()].map(zeros))
        });
        for _ in 0..self.substeps {
            if let Some((drift, zeros)) = first {
                nodes = self.drifted(p, drift, zeros, nodes, given);
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
                    decay: self.flight.decay,
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
            for (force, given) in self.forces.iter().zip(&given.forces) {
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
                uniforms: &given.contact,
            };
            nodes = self.contact.fly(p, self.flight, terrain, pushed);
        }
        nodes
    }

    /// Records a drift, which is a flight without a push. `zero` is a single zero, and `zeros` has one for each node.
    fn drifted(
        &self,
        p: &mut Program,
        drift: Drift,
        [zero, zeros]: [Array; 2],
        nodes: Particle<Array>,
        given: &Parameters<Array>,
    ) -> Particle<Array> {
        let pushed = FlightInputs {
            nodes,
            impulses: Vector::new([zeros; 2]),
            inverse_mass: given.inverse_mass,
            uniforms: &[&[zero; 2], &given.contact[2..]].concat(),
        };
        let flight = Flight { drift, decay: 1.0 };
        self.contact.fly(p, flight, self.terrain.as_ref(), pushed)
    }

    /// Records the meter after an explicit push in which nodes get these impulses (N s).
    fn metered(
        &self,
        p: &mut Program,
        step: &Step,
        given: &Parameters<Array>,
        impulses: Vector<Array>,
        before: Meter,
    ) -> Meter {
        let tension = effort::tension(p, step, &self.forces, given);
        let pulling = BarImpulse {
            dt: step.dt,
            softening: step.softening,
        };
        let positions = step.nodes.x.array();
        let pulls = p.map_each_edge(step.graph, pulling, positions, &[tension], &[]);
        let ([vx, vy], [jx, jy]) = (step.nodes.v.array(), impulses.array());
        let node = [vx, vy, jx, jy, given.inverse_mass];
        let moving = p.map(MeanVelocity(self.flight), node, &given.contact[..2]);
        before.after(p, step.graph, Vector::new(moving), pulls, tension)
    }
}
