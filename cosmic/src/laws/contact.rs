//! Contact laws: the velocity of a node that meets the ground.

use std::fmt::Debug;

use autodiff::arrays::vjp_by_duals;
use autodiff::{AnyProgram, Array, Kernel, Pullback, Real};

use super::law::Law;
use super::motion::{Drift, Flight};
use super::terrain::{NONE, Terrain, Way, moved, select};
use crate::settings::Settings;

/// A node that meets the ground.
#[derive(Clone, Copy, Debug)]
pub struct Impact<R> {
    /// Its velocity before, m/s: along the ground, and out of it (negative).
    pub velocity: [R; 2],
    /// The time that is left of the drift, s.
    pub rest: R,
}

/// What happens to a node that meets the ground. To write one, give it [settings](Law) and
/// [`respond`](Contact::respond); derivatives, lanes and files follow.
///
/// Mark its methods `#[inline(always)]`: [`Kernel`] says why.
pub trait Contact: Law {
    /// False if there is no ground at all.
    const HAS_GROUND: bool = true;

    /// The velocity after the impact, m/s, which the node keeps for the rest of the drift. Like all
    /// generic code it selects and never branches.
    fn respond<R: Real>(&self, impact: Impact<R>) -> [R; 2];

    /// A node at `place` (m) that drifts with `velocity`: its new `[x, y, vx, vy]`.
    #[inline(always)]
    fn drift<R: Real>(&self, drift: &Drift, place: [R; 2], velocity: [R; 2]) -> [R; 4] {
        let [x, y] = place;
        let [vx, vy] = velocity;
        let (touches, moving) = drift.touch(y, vy);
        let rest = R::lit(drift.dt) - moving;
        let [ax, ay] = self.respond(Impact { velocity, rest });
        let after = |way: R| R::select(touches, rest * way, R::zero());
        [
            moving.fma(vx, x) + after(ax),
            moving.fma(vy, y) + after(ay),
            R::select(touches, ax, vx),
            R::select(touches, ay, vy),
        ]
    }

    /// A node that drifts over terrain, from and to the numbers of [`drift`](Contact::drift). Where it meets a
    /// segment, the law has its velocity along that segment and out of it. In a corner, where the way that
    /// is left leads into another segment, the law is asked once more, and a node that even then would not
    /// stay above the ground stops in that corner.
    #[inline(always)]
    fn drift_over<R: Real>(
        &self,
        terrain: &Terrain,
        drift: &Drift,
        place: [R; 2],
        velocity: [R; 2],
    ) -> [R; 4] {
        let mut way = Way {
            place,
            velocity,
            left: R::lit(drift.dt),
        };
        let mut met = R::lit(NONE);
        for _ in 0..2 {
            let meeting = terrain.meet(&way, met);
            let Way {
                place,
                velocity,
                left,
            } = meeting.reached(&way);
            let after = meeting.in_ground(self.respond(Impact {
                velocity,
                rest: left,
            }));
            way = Way {
                place,
                velocity: select(meeting.touches, after, way.velocity),
                left,
            };
            met = meeting.segment;
        }
        let stops = terrain.meet(&way, met).touches;
        let [vx, vy] = select(stops, [R::zero(); 2], way.velocity);
        let [x, y] = moved(way.place, way.left, [vx, vy]);
        [x, y, vx, vy]
    }

    /// The law under another coefficient of friction, where it has one: that of the scene, and those
    /// drawn for a robot that must stand several.
    #[must_use]
    fn with_friction(self, _friction: f64) -> Self {
        self
    }

    /// The adjoint of a step: an [emitted](autodiff::emit) one is faster.
    #[inline(always)]
    fn flying_vjp<R: Real, const M: usize>(
        flying: &Flying<Self>,
        at: Pullback<R, 7, 4, M>,
    ) -> [[R; 7]; M] {
        vjp_by_duals(flying, at)
    }

    /// The adjoint of a drift that nothing pushes.
    #[inline(always)]
    fn drifting_vjp<R: Real, const M: usize>(
        drifting: &Drifting<Self>,
        at: Pullback<R, 4, 4, M>,
    ) -> [[R; 4]; M] {
        vjp_by_duals(drifting, at)
    }
}

/// A step of a node: from `[x, y, vx, vy, impulse x, impulse y, 1 / mass]` to the new
/// `[x, y, vx, vy]`.
#[derive(Clone, Debug)]
pub struct Flying<C> {
    /// The push, and the drift after it.
    pub flight: Flight,
    /// What happens at the ground.
    pub contact: C,
}

impl<C: Contact> Kernel<7, 4> for Flying<C> {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7]) -> [R; 4] {
        let v = self.flight.velocity([vx, vy], [jx, jy], inverse_mass);
        self.contact.drift(&self.flight.drift, [x, y], v)
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 7, 4, M>) -> [[R; 7]; M] {
        C::flying_vjp(self, at)
    }
}

/// A drift that nothing pushes: from `[x, y, vx, vy]` to the new ones.
#[derive(Clone, Debug)]
pub struct Drifting<C> {
    /// The drift.
    pub drift: Drift,
    /// What happens at the ground.
    pub contact: C,
}

impl<C: Contact> Kernel<4, 4> for Drifting<C> {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy]: [R; 4]) -> [R; 4] {
        self.contact.drift(&self.drift, [x, y], [vx, vy])
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 4, 4, M>) -> [[R; 4]; M] {
        C::drifting_vjp(self, at)
    }
}

/// A step of a node over terrain, with the numbers of [`Flying`].
#[derive(Clone, Debug)]
pub(super) struct FlyingOver<C> {
    pub(super) terrain: Terrain,
    pub(super) flying: Flying<C>,
}

impl<C: Contact> Kernel<7, 4> for FlyingOver<C> {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7]) -> [R; 4] {
        let Flying { flight, contact } = &self.flying;
        let v = flight.velocity([vx, vy], [jx, jy], inverse_mass);
        contact.drift_over(&self.terrain, &flight.drift, [x, y], v)
    }
}

/// A drift over terrain, with the numbers of [`Drifting`].
#[derive(Clone, Debug)]
pub(super) struct DriftingOver<C> {
    pub(super) terrain: Terrain,
    pub(super) drifting: Drifting<C>,
}

impl<C: Contact> Kernel<4, 4> for DriftingOver<C> {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, vx, vy]: [R; 4]) -> [R; 4] {
        let Drifting { drift, contact } = &self.drifting;
        contact.drift_over(&self.terrain, drift, [x, y], [vx, vy])
    }
}

/// A [`Contact`] behind a pointer.
pub(crate) trait AnyContact: Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn has_ground(&self) -> bool;
    fn settings(&mut self) -> &mut dyn Settings;
    fn boxed(&self) -> Box<dyn AnyContact>;
    fn with_friction(&self, friction: f64) -> Box<dyn AnyContact>;
    /// The state of all nodes after a step over terrain, or over the ground line; see [`Flying`].
    fn fly(
        &self,
        p: &mut AnyProgram,
        flight: Flight,
        terrain: Option<&Terrain>,
        node: [Array; 7],
    ) -> [Array; 4];
    /// The state of all nodes after a drift over terrain, or over the ground line; see [`Drifting`].
    fn drift(
        &self,
        p: &mut AnyProgram,
        drift: Drift,
        terrain: Option<&Terrain>,
        node: [Array; 4],
    ) -> [Array; 4];
}

impl<C: Contact> AnyContact for C {
    fn name(&self) -> &'static str {
        C::NAME
    }
    fn has_ground(&self) -> bool {
        C::HAS_GROUND
    }
    fn settings(&mut self) -> &mut dyn Settings {
        self
    }
    fn boxed(&self) -> Box<dyn AnyContact> {
        Box::new(self.clone())
    }
    fn with_friction(&self, friction: f64) -> Box<dyn AnyContact> {
        Box::new(self.clone().with_friction(friction))
    }
    fn fly(
        &self,
        p: &mut AnyProgram,
        flight: Flight,
        terrain: Option<&Terrain>,
        node: [Array; 7],
    ) -> [Array; 4] {
        let contact = self.clone();
        let flying = Flying { flight, contact };
        match terrain.cloned().filter(|_| C::HAS_GROUND) {
            None => p.map(flying, node),
            Some(terrain) => p.map(FlyingOver { terrain, flying }, node),
        }
    }
    fn drift(
        &self,
        p: &mut AnyProgram,
        drift: Drift,
        terrain: Option<&Terrain>,
        node: [Array; 4],
    ) -> [Array; 4] {
        let contact = self.clone();
        let drifting = Drifting { drift, contact };
        match terrain.cloned().filter(|_| C::HAS_GROUND) {
            None => p.map(drifting, node),
            Some(terrain) => p.map(DriftingOver { terrain, drifting }, node),
        }
    }
}
