//! The mechanical part of a step: springs, flight and contact, as often as a scene asks for.

use autodiff::{Array, Graph, Program, Real};

use super::kernels::{Drift, Flight, Sliding, SlidingDrift, Spring, Sticking, StickingDrift};
use super::trap::Watch;
use crate::lattice::Ground;
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
    pub(super) spring: Spring,
    pub(super) flight: Flight,
    contact: Contact,
    friction: f64,
}

impl Mechanics {
    pub(super) fn new(physics: &PhysicsSettings) -> Self {
        let h = physics.dt / physics.substeps as f64;
        let decay = (-physics.damping * h).exp();
        // What the second half of the damping leaves of a push.
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
    /// before it, four arrays per edge (activation, stiffness, rest length, strain) and 1 / mass.
    /// Every flight is watched by `W`.
    pub(super) fn record<R: Real, W: Watch>(
        &self,
        (p, graph): (&mut Program<R>, &Graph),
        state: [Array; 4],
        (edge, inverse_mass): (&[Array; 4], Array),
    ) -> [Array; 4] {
        let mut state = state;
        for _ in 0..self.substeps {
            if let Some(drift) = self.first {
                state = self.drift(p, drift, state);
            }
            let [x, y, ..] = state;
            let [jx, jy] = p.map_edges(graph, self.spring, ([x, y], edge));
            let [x, y, vx, vy] = state;
            state = self.fly::<R, W>(p, [x, y, vx, vy, jx, jy, inverse_mass]);
        }
        state
    }

    fn drift<R: Real>(&self, p: &mut Program<R>, drift: Drift, node: [Array; 4]) -> [Array; 4] {
        let friction = self.friction;
        match self.contact {
            Contact::None => p.map(drift, node),
            Contact::Infinite => p.map(StickingDrift(drift), node),
            Contact::Coulomb => p.map(SlidingDrift { drift, friction }, node),
        }
    }

    fn fly<R: Real, W: Watch>(&self, p: &mut Program<R>, node: [Array; 7]) -> [Array; 4] {
        let (flight, friction) = (self.flight, self.friction);
        match self.contact {
            Contact::None => W::fly(p, flight, node),
            Contact::Infinite => W::stick(p, Sticking(flight), node),
            Contact::Coulomb => W::slide(p, Sliding { flight, friction }, node),
        }
    }
}
