//! The mechanical part of a step: springs, flight and contact, as often as a scene asks for.

use autodiff::{Array, Graph, Kernel, Program, Real};

use super::bending::{Bending, BentPair};
use super::kernels::{
    Drift, Flight, FreeDrift, Sliding, SlidingDrift, Spring, Sticking, StickingDrift, Stiffening,
};
use crate::ground::Ground;
use crate::lattice::Lattice;
use crate::scene::{Contact, Integrator, PhysicsSettings};

/// Springs and flight of a mechanical step of length `h = dt / substeps`.
///
/// Symplectic Euler pushes for `h` with the forces at the start, and drifts for `h`. Leapfrog
/// drifts for `h / 2`, pushes for `h` and drifts for `h / 2`, each drift with its own contact;
/// half of the damping before the push and half after it make the whole symmetric in time, and
/// of second order.
#[derive(Clone, Debug)]
pub(super) struct Mechanics {
    substeps: usize,
    /// The drift before the forces are taken, where the integrator has one.
    first: Option<Drift>,
    spring: Spring,
    /// The cubic coefficient of the springs, 1/m^2; 0 for Hooke's law.
    stiffening: f64,
    /// `None` where bars bend freely.
    pub(super) bending: Option<Bending>,
    pub(super) flight: Flight,
    contact: Contact,
    pub(super) friction: f64,
}

impl Mechanics {
    pub(super) fn new(lattice: &Lattice, physics: &PhysicsSettings) -> Self {
        let h = physics.dt / physics.substeps as f64;
        let decay = (-physics.damping * h).exp();
        // Leapfrog damps by half after a push, which takes its part of that.
        let (first, drift, push) = match physics.integrator {
            Integrator::SymplecticEuler => (None, Drift { dt: h }, h),
            Integrator::Leapfrog => {
                let half = Drift { dt: 0.5 * h };
                (Some(half), half, h * decay.sqrt())
            }
        };
        Self {
            substeps: physics.substeps,
            first,
            spring: Spring { dt: push },
            stiffening: physics.stiffening,
            bending: Bending::new(lattice, physics.bending_radius),
            flight: Flight {
                drift,
                decay,
                gravity: Ground::from(physics).vector_to_ground([0.0, -physics.gravity * push]),
            },
            contact: physics.contact,
            friction: physics.friction,
        }
    }

    /// Records the state after the step: x, y, x velocity, y velocity of all nodes, from those
    /// before it, four arrays per edge (activation, stiffness, rest length, strain), 1 / mass, and
    /// the stiffness against bending where there is any.
    pub(super) fn record<R: Real>(
        &self,
        p: &mut Program<R>,
        graph: &Graph,
        state: [Array; 4],
        edge: &[Array; 4],
        inverse_mass: Array,
        bending: Option<Array>,
    ) -> [Array; 4] {
        let mut state = state;
        for _ in 0..self.substeps {
            if let Some(drift) = self.first {
                state = self.drift(p, drift, state);
            }
            let [x, y, ..] = state;
            let [jx, jy] = self.pull(p, graph, [x, y], edge, bending);
            let [x, y, vx, vy] = state;
            state = self.fly(p, [x, y, vx, vy, jx, jy, inverse_mass]);
        }
        state
    }

    /// The impulses on all nodes.
    fn pull<R: Real>(
        &self,
        p: &mut Program<R>,
        graph: &Graph,
        place: [Array; 2],
        edge: &[Array; 4],
        bending: Option<Array>,
    ) -> [Array; 2] {
        let (spring, cubic) = (self.spring, self.stiffening);
        let springs = if cubic > 0.0 {
            p.map_edges(graph, Stiffening { spring, cubic }, place, edge)
        } else {
            p.map_edges(graph, spring, place, edge)
        };
        match self.bending.as_ref().zip(bending) {
            None => springs,
            Some((bending, stiffness)) => bending.record(p, stiffness, spring.dt, place, springs),
        }
    }

    /// The impulse of one spring on its tail, N s, from what [`Spring`] takes.
    pub(super) fn spring_impulse(&self, given: [f64; 6]) -> [f64; 2] {
        let (spring, cubic) = (self.spring, self.stiffening);
        if cubic > 0.0 {
            Stiffening { spring, cubic }.eval(given)
        } else {
            spring.eval(given)
        }
    }

    /// The impulses of bent bars on their nodes, N s, from the edges' stiffness and the nodes'
    /// places; none where bars bend freely.
    pub(super) fn bending_impulses(&self, stiffness: &[f64], x: &[[f64; 2]]) -> Vec<BentPair> {
        let bending = self.bending.as_ref();
        bending.map_or(Vec::new(), |b| b.impulses(stiffness, self.spring.dt, x))
    }

    fn drift<R: Real>(&self, p: &mut Program<R>, drift: Drift, node: [Array; 4]) -> [Array; 4] {
        let friction = self.friction;
        match self.contact {
            Contact::None => p.map(FreeDrift(drift), node),
            Contact::Infinite => p.map(StickingDrift(drift), node),
            Contact::Coulomb => p.map(SlidingDrift { drift, friction }, node),
        }
    }

    fn fly<R: Real>(&self, p: &mut Program<R>, node: [Array; 7]) -> [Array; 4] {
        let (flight, friction) = (self.flight, self.friction);
        match self.contact {
            Contact::None => p.map(flight, node),
            Contact::Infinite => p.map(Sticking(flight), node),
            Contact::Coulomb => p.map(Sliding { flight, friction }, node),
        }
    }
}
