//! Contact laws: the velocity of a node that meets the ground.

use std::fmt::Debug;

use autodiff::arrays::{Uniforms, vjp_by_duals_with};
use autodiff::{AnyProgram, Array, Kernel, Pullback, Real};

use super::law::{Law, StepInput, step_inputs, uniforms};
use super::motion::{Drift, Flight, Particle};
use super::terrain::{NONE, Terrain, Way};
use crate::geometry::Vector;
use crate::settings::Settings;

/// A node that meets the ground.
#[derive(Clone, Copy, Debug)]
pub struct Impact<R, const D: usize = 2> {
    /// Its velocity before, m/s. The last component is out of the ground, and negative here.
    pub velocity: Vector<R, D>,
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
    fn respond<R: Real, const D: usize>(law: &Self::Of<R>, impact: Impact<R, D>) -> Vector<R, D>;

    /// A node after a drift over the ground line.
    #[inline(always)]
    fn drift<R: Real, const D: usize>(
        law: &Self::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        let (touches, moving) = drift.touch(node);
        let (velocity, rest) = (node.v, R::lit(drift.dt) - moving);
        let after = Self::respond(law, Impact { velocity, rest });
        Particle {
            x: node.after(moving).x + Vector::select(touches, after * rest, Vector::zero()),
            v: Vector::select(touches, after, velocity),
        }
    }

    /// A node after a drift over terrain. Where it meets a segment, the law has its velocity along that segment
    /// and out of it. In a corner, where the way that is left leads into another segment, the law is asked once
    /// more, and a node that even then would not stay above the ground stops in that corner.
    #[inline(always)]
    fn drift_over<R: Real, const D: usize>(
        law: &Self::Of<R>,
        terrain: &Terrain,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        let left = R::lit(drift.dt);
        let mut way = Way { node, left };
        let mut met = R::lit(NONE);
        for _ in 0..2 {
            let meeting = terrain.meet(&way, met);
            let Way { node, left } = meeting.reached(&way);
            let impact = Impact {
                velocity: node.v,
                rest: left,
            };
            let after = Self::respond(law, impact);
            let v = Vector::select(meeting.touches, meeting.in_ground(after), way.node.v);
            way = Way {
                node: Particle { x: node.x, v },
                left,
            };
            met = meeting.segment;
        }
        let stops = terrain.meet(&way, met).touches;
        let v = Vector::select(stops, Vector::zero(), way.node.v);
        Particle { v, ..way.node }.after(way.left)
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
        given: &Uniforms<R>,
    ) -> [[R; 7]; M] {
        vjp_by_duals_with(flying, at, given)
    }

    /// The adjoint of a drift that nothing pushes.
    #[inline(always)]
    fn drifting_vjp<R: Real, const M: usize>(
        drifting: &Drifting<Self>,
        at: Pullback<R, 4, 4, M>,
        settings: &Uniforms<R>,
    ) -> [[R; 4]; M] {
        vjp_by_duals_with(drifting, at, settings)
    }
}

/// A step of a node: from `[x, y, vx, vy, impulse x, impulse y, 1 / mass]` to the new
/// `[x, y, vx, vy]`. The uniform inputs are the two components of [`Flight::gravity`], then the law's settings.
#[derive(Clone, Debug)]
pub struct Flying<C, const D: usize = 2> {
    /// The push, and the drift after it.
    pub flight: Flight<D>,
    /// What happens at the ground.
    pub contact: C,
}

impl<C: Contact, const D: usize> Flying<C, D> {
    /// A node that an impulse (N s) has pushed, and the law with the settings given.
    #[inline(always)]
    fn pushed<R: Real>(
        &self,
        node: Particle<R, D>,
        (impulse, inverse_mass): (Vector<R, D>, R),
        given: &Uniforms<R>,
    ) -> (Particle<R, D>, C::Of<R>) {
        let mut gravity = Vector::zero();
        for axis in 0..D {
            gravity[axis] = given[axis];
        }
        let v = (self.flight).velocity(node.v, impulse, inverse_mass, gravity);
        (Particle { v, ..node }, self.contact.of(&given[D..]))
    }

    fn uniforms<R: Real>(&self) -> Uniforms<R> {
        let gravity: Vec<f64> = self.flight.gravity.iter().copied().collect();
        uniforms(&gravity, &self.contact)
    }
}

impl<C: Contact> Kernel<7, 4> for Flying<C> {
    const UNIFORMS: usize = 2 + C::COUNT;

    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; 7]) -> [R; 4] {
        self.eval_with(x, &self.uniforms())
    }

    #[inline(always)]
    fn eval_with<R: Real>(
        &self,
        [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7],
        given: &Uniforms<R>,
    ) -> [R; 4] {
        let (node, impulse) = (Particle::new([x, y, vx, vy]), Vector::new([jx, jy]));
        let (node, contact) = self.pushed(node, (impulse, inverse_mass), given);
        C::drift(&contact, &self.flight.drift, node).array()
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 7, 4, M>) -> [[R; 7]; M] {
        self.vjp_with(at, &self.uniforms())
    }

    #[inline(always)]
    fn vjp_with<R: Real, const M: usize>(
        &self,
        at: Pullback<R, 7, 4, M>,
        given: &Uniforms<R>,
    ) -> [[R; 7]; M] {
        C::flying_vjp(self, at, given)
    }
}

/// A drift that nothing pushes: from `[x, y, vx, vy]` to the new ones. The uniform inputs are the law's settings.
#[derive(Clone, Debug)]
pub struct Drifting<C> {
    /// The drift.
    pub drift: Drift,
    /// What happens at the ground.
    pub contact: C,
}

impl<C: Contact> Kernel<4, 4> for Drifting<C> {
    const UNIFORMS: usize = C::COUNT;

    #[inline(always)]
    fn eval<R: Real>(&self, node: [R; 4]) -> [R; 4] {
        self.eval_with(node, &uniforms(&[], &self.contact))
    }

    #[inline(always)]
    fn eval_with<R: Real>(&self, node: [R; 4], settings: &Uniforms<R>) -> [R; 4] {
        let contact = self.contact.of(settings);
        C::drift(&contact, &self.drift, Particle::new(node)).array()
    }

    #[inline(always)]
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 4, 4, M>) -> [[R; 4]; M] {
        self.vjp_with(at, &uniforms(&[], &self.contact))
    }

    #[inline(always)]
    fn vjp_with<R: Real, const M: usize>(
        &self,
        at: Pullback<R, 4, 4, M>,
        settings: &Uniforms<R>,
    ) -> [[R; 4]; M] {
        C::drifting_vjp(self, at, settings)
    }
}

/// A step of a node over terrain, with the numbers of [`Flying`].
#[derive(Clone, Debug)]
pub(super) struct FlyingOver<C> {
    pub(super) terrain: Terrain,
    pub(super) flying: Flying<C>,
}

impl<C: Contact> Kernel<7, 4> for FlyingOver<C> {
    const UNIFORMS: usize = 2 + C::COUNT;

    #[inline(always)]
    fn eval<R: Real>(&self, x: [R; 7]) -> [R; 4] {
        self.eval_with(x, &self.flying.uniforms())
    }

    #[inline(always)]
    fn eval_with<R: Real>(
        &self,
        [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7],
        given: &Uniforms<R>,
    ) -> [R; 4] {
        let (node, impulse) = (Particle::new([x, y, vx, vy]), Vector::new([jx, jy]));
        let (node, contact) = self.flying.pushed(node, (impulse, inverse_mass), given);
        let drift = &self.flying.flight.drift;
        C::drift_over(&contact, &self.terrain, drift, node).array()
    }

    #[inline(always)]
    fn vjp_with<R: Real, const M: usize>(
        &self,
        at: Pullback<R, 7, 4, M>,
        given: &Uniforms<R>,
    ) -> [[R; 7]; M] {
        vjp_by_duals_with(self, at, given)
    }
}

/// A drift over terrain, with the numbers of [`Drifting`].
#[derive(Clone, Debug)]
pub(super) struct DriftingOver<C> {
    pub(super) terrain: Terrain,
    pub(super) drifting: Drifting<C>,
}

impl<C: Contact> Kernel<4, 4> for DriftingOver<C> {
    const UNIFORMS: usize = C::COUNT;

    #[inline(always)]
    fn eval<R: Real>(&self, node: [R; 4]) -> [R; 4] {
        self.eval_with(node, &uniforms(&[], &self.drifting.contact))
    }

    #[inline(always)]
    fn eval_with<R: Real>(&self, node: [R; 4], settings: &Uniforms<R>) -> [R; 4] {
        let Drifting { drift, contact } = &self.drifting;
        let node = Particle::new(node);
        C::drift_over(&contact.of(settings), &self.terrain, drift, node).array()
    }

    #[inline(always)]
    fn vjp_with<R: Real, const M: usize>(
        &self,
        at: Pullback<R, 4, 4, M>,
        settings: &Uniforms<R>,
    ) -> [[R; 4]; M] {
        vjp_by_duals_with(self, at, settings)
    }
}

/// A [`Contact`] behind a pointer.
pub(crate) trait AnyContact: Debug + Send + Sync {
    fn name(&self) -> &'static str;
    fn has_ground(&self) -> bool;
    fn settings(&mut self) -> &mut dyn Settings;
    fn inputs(&self) -> Vec<StepInput>;
    fn boxed(&self) -> Box<dyn AnyContact>;
    fn with_friction(&self, friction: f64) -> Box<dyn AnyContact>;
    /// All nodes after a step; see [`Flying`].
    fn fly(
        &self,
        p: &mut AnyProgram,
        flight: Flight,
        terrain: Option<&Terrain>,
        pushed: Pushed,
    ) -> Particle<Array>;
    /// All nodes after a drift; see [`Drifting`].
    fn drift(
        &self,
        p: &mut AnyProgram,
        drift: Drift,
        terrain: Option<&Terrain>,
        nodes: Particle<Array>,
        settings: &[Array],
    ) -> Particle<Array>;
}

/// All nodes, and what pushes them.
pub(crate) struct Pushed<'a, const D: usize = 2> {
    pub(crate) nodes: Particle<Array, D>,
    /// Impulses, N s.
    pub(crate) impulses: Vector<Array, D>,
    /// 1 / mass, 1/kg.
    pub(crate) inverse_mass: Array,
    /// The velocity that gravity adds, m/s, then the settings of the contact law: an array of one number each.
    pub(crate) uniforms: &'a [Array],
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
    fn inputs(&self) -> Vec<StepInput> {
        step_inputs(self)
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
        pushed: Pushed,
    ) -> Particle<Array> {
        let contact = self.clone();
        let flying = Flying { flight, contact };
        let ([x, y, vx, vy], [jx, jy]) = (pushed.nodes.array(), pushed.impulses.array());
        let node = [x, y, vx, vy, jx, jy, pushed.inverse_mass];
        Particle::new(match terrain.cloned().filter(|_| C::HAS_GROUND) {
            None => p.map_with(flying, node, pushed.uniforms),
            Some(terrain) => p.map_with(FlyingOver { terrain, flying }, node, pushed.uniforms),
        })
    }
    fn drift(
        &self,
        p: &mut AnyProgram,
        drift: Drift,
        terrain: Option<&Terrain>,
        nodes: Particle<Array>,
        settings: &[Array],
    ) -> Particle<Array> {
        let (contact, node) = (self.clone(), nodes.array());
        let drifting = Drifting { drift, contact };
        Particle::new(match terrain.cloned().filter(|_| C::HAS_GROUND) {
            None => p.map_with(drifting, node, settings),
            Some(terrain) => p.map_with(DriftingOver { terrain, drifting }, node, settings),
        })
    }
}
