//! Contact laws: they determine the velocity of a node after it has met the ground.

use std::fmt::Debug;

use autodiff::arrays::vjp_by_duals;
use autodiff::{Kernel, Pullback, Real};

use super::law::Law;
use super::motion::{Drift, Flight, Particle};
use super::terrain::{NONE, RemainingDrift, Terrain};
use crate::geometry::{Plane, Vector};
use crate::kernel;

/// A node at the moment when it meets the ground.
#[derive(Clone, Copy, Debug)]
pub struct Impact<R, const D: usize = 2> {
    /// The velocity before the impact, m/s. The first component is along the ground. The last component is along the
    /// normal that points out of the ground; it is negative, because the node moves into the ground.
    pub velocity: Vector<R, D>,
    /// The time that remains of the drift after the impact, s.
    pub rest: R,
}

/// A contact law: what happens to a node that meets the ground. To write a law, give it [settings](Law) and
/// [`respond`](Contact::respond). Derivatives, SIMD lanes and file formats need no further code.
///
/// The `impl` needs the attribute [`kernel`](macro@crate::kernel), and so do functions that the methods call.
pub trait Contact: Law {
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();

    /// False if the world of this law has no ground.
    const HAS_GROUND: bool = true;

    /// The velocity after the impact, m/s, which the node keeps for the rest of the drift. `law` has the settings as
    /// numbers of the type `R`. The method must not branch on a [`Real`]; use `R::select` instead.
    fn respond<R: Real, const D: usize>(law: &Self::Of<R>, impact: Impact<R, D>) -> Vector<R, D>;

    /// Computes the node after a drift over flat ground.
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

    /// The largest friction of this law, as a multiple of the impulse out of the ground. An implicit step needs it; above
    /// 1000 a node sticks. By default it is measured: by how much the law slows down a node that moves fast along the
    /// ground and into it at 1 m/s.
    #[inline(always)]
    fn grip<R: Real>(law: &Self::Of<R>) -> R {
        let fast = R::lit(FAST);
        let (velocity, rest) = (Vector::<R, 2>::upright(fast, -R::one()), R::zero());
        fast - Self::respond(law, Impact { velocity, rest }).forward()
    }

    /// Computes the node after a drift over terrain. The node does not meet segment number `but`; -1 stands for no
    /// segment. If it meets another segment, the law gets the components of the velocity along that segment and out of
    /// it. If the rest of the drift leads into yet another segment, as in a corner, the law is applied a second time. If
    /// the node would sink into the ground even then, it stops in the corner.
    #[inline(always)]
    fn drift_over<R: Real, const D: usize>(
        law: &Self::Of<R>,
        terrain: &Terrain,
        drift: &Drift,
        node: Particle<R, D>,
        but: R,
    ) -> Particle<R, D> {
        let left = R::lit(drift.dt);
        let node = terrain.beside_walls(node, R::lit(NONE));
        let mut way = RemainingDrift { node, left };
        let mut met = but;
        for _ in 0..2 {
            let hit = terrain.meet(&way, met);
            let RemainingDrift { node, left } = hit.reached(&way);
            let node = terrain.beside_walls(node, hit.segment);
            let impact = Impact {
                velocity: node.v,
                rest: left,
            };
            let after = Self::respond(law, impact);
            let v = Vector::select(hit.touches, hit.in_ground(after), way.node.v);
            way = RemainingDrift {
                node: Particle { x: node.x, v },
                left,
            };
            met = hit.segment;
        }
        let stops = terrain.meet(&way, met).touches;
        let v = Vector::select(stops, Vector::zero(), way.node.v);
        Particle { v, ..way.node }.after(way.left)
    }

    /// This law with another coefficient of friction: the value of `physics.friction`, or a value that is drawn for
    /// domain randomization. A law without friction does not change.
    #[must_use]
    fn with_friction(self, _friction: f64) -> Self {
        self
    }

    /// The adjoint of the kernel [`Flying`] over flat ground. The default works for every law; a
    /// [generated](autodiff::emit) adjoint is faster.
    #[inline(always)]
    fn flying_vjp<R: Real, const M: usize>(
        flying: &Flying<Self>,
        at: Pullback<R, 7, 4, M>,
    ) -> [[R; 7]; M] {
        vjp_by_duals(flying, at)
    }

    /// The adjoint of the kernel [`Drifting`] over flat ground. As for [`flying_vjp`](Contact::flying_vjp), the default
    /// works for every law.
    #[inline(always)]
    fn drifting_vjp<R: Real, const M: usize>(
        drifting: &Drifting<Self>,
        at: Pullback<R, 4, 4, M>,
    ) -> [[R; 4]; M] {
        vjp_by_duals(drifting, at)
    }
}

/// Defines the methods of an `impl` of [`Contact`] that call the generated adjoints of the law.
macro_rules! emitted_adjoints {
    () => {
        #[inline(always)]
        fn flying_vjp<R: Real, const M: usize>(
            flying: &Flying<Self>,
            at: autodiff::Pullback<R, 7, 4, M>,
        ) -> [[R; 7]; M] {
            flying.emitted_vjp(at)
        }

        #[inline(always)]
        fn drifting_vjp<R: Real, const M: usize>(
            drifting: &Drifting<Self>,
            at: autodiff::Pullback<R, 4, 4, M>,
        ) -> [[R; 4]; M] {
            drifting.emitted_vjp(at)
        }
    };
}
pub(super) use emitted_adjoints;

/// The speed, m/s, with which [`Contact::grip`] measures friction.
const FAST: f64 = 2e3;

/// The kind of ground that a node drifts over: [`Flat`] or [`Terrain`].
pub trait Surface: Clone + Debug + Send + Sync + Sized + 'static {
    #[doc(hidden)]
    const USE_THE_ATTRIBUTE_KERNEL: ();

    /// Whether kernels over this ground are [compiled](Kernel::COMPILED).
    const COMPILED: bool;

    /// Computes the node after a drift over this ground with a contact law.
    fn drift<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D>;

    /// Like [`drift`](Self::drift), but the node does not meet segment number `but`; -1 stands for no segment.
    fn drift_but<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
        but: R,
    ) -> Particle<R, D>;

    /// Whether a node meets the ground within a time `dt` (s) in which it moves at constant velocity, and the number of the
    /// segment that it meets. They have no derivative.
    fn meets<R: Real, const D: usize>(&self, node: Particle<R, D>, dt: f64) -> (R::Mask, R);

    /// The plane of a segment.
    fn plane<R: Real>(&self, segment: R) -> Plane<R>;

    /// The adjoint of the kernel [`Flying`] over this ground.
    #[inline(always)]
    fn flying_vjp<C: Contact, R: Real, const M: usize>(
        flying: &Flying<C, Self>,
        at: Pullback<R, 7, 4, M>,
    ) -> [[R; 7]; M] {
        vjp_by_duals(flying, at)
    }

    /// The adjoint of the kernel [`Drifting`] over this ground.
    #[inline(always)]
    fn drifting_vjp<C: Contact, R: Real, const M: usize>(
        drifting: &Drifting<C, Self>,
        at: Pullback<R, 4, 4, M>,
    ) -> [[R; 4]; M] {
        vjp_by_duals(drifting, at)
    }
}

/// A flat ground line. It is also used if there is no ground.
#[derive(Clone, Copy, Debug)]
pub struct Flat;

#[kernel]
impl Surface for Flat {
    const COMPILED: bool = true;

    fn drift<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        C::drift(law, drift, node)
    }

    fn drift_but<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
        but: R,
    ) -> Particle<R, D> {
        let [falls, slides] = [C::drift(law, drift, node), node.after(R::lit(drift.dt))];
        let ignored = R::lit(NONE).less(but);
        Particle {
            x: Vector::select(ignored, slides.x, falls.x),
            v: Vector::select(ignored, slides.v, falls.v),
        }
    }

    fn meets<R: Real, const D: usize>(&self, node: Particle<R, D>, dt: f64) -> (R::Mask, R) {
        (Drift { dt }.touch(node).0, R::zero())
    }

    fn plane<R: Real>(&self, _: R) -> Plane<R> {
        Plane::LEVEL.lit()
    }

    fn flying_vjp<C: Contact, R: Real, const M: usize>(
        flying: &Flying<C>,
        at: Pullback<R, 7, 4, M>,
    ) -> [[R; 7]; M] {
        C::flying_vjp(flying, at)
    }

    fn drifting_vjp<C: Contact, R: Real, const M: usize>(
        drifting: &Drifting<C>,
        at: Pullback<R, 4, 4, M>,
    ) -> [[R; 4]; M] {
        C::drifting_vjp(drifting, at)
    }
}

#[kernel]
impl Surface for Terrain {
    const COMPILED: bool = false;

    fn drift<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        C::drift_over(law, self, drift, node, R::lit(NONE))
    }

    fn drift_but<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
        but: R,
    ) -> Particle<R, D> {
        C::drift_over(law, self, drift, node, but)
    }

    fn meets<R: Real, const D: usize>(&self, node: Particle<R, D>, dt: f64) -> (R::Mask, R) {
        let (none, left) = (R::lit(NONE), R::lit(dt));
        let node = self.beside_walls(node, none);
        let hit = self.meet(&RemainingDrift { node, left }, none);
        (hit.touches, hit.segment)
    }

    fn plane<R: Real>(&self, segment: R) -> Plane<R> {
        self.plane_of(segment)
    }
}

/// The kernel of one step of a node: a push that changes the velocity, then a drift that changes the position. It maps
/// `[x, y, vx, vy, impulse x, impulse y, 1 / mass]` to the new `[x, y, vx, vy]`. The uniform inputs are the two
/// components of the velocity that gravity adds (m/s), then the law's settings.
#[derive(Clone, Debug)]
pub struct Flying<C, G = Flat> {
    /// The numbers that determine the push and the drift.
    pub flight: Flight,
    /// The contact law.
    pub contact: C,
    /// The ground.
    pub ground: G,
}

#[kernel]
impl<C: Contact, G: Surface> Kernel<7, 4> for Flying<C, G> {
    const UNIFORMS: usize = 2 + C::COUNT;
    const COMPILED: bool = C::COMPILED && G::COMPILED;

    fn eval<R: Real>(&self, [x, y, vx, vy, jx, jy, inverse_mass]: [R; 7], given: &[R]) -> [R; 4] {
        let (node, impulse) = (Particle::new([x, y, vx, vy]), Vector::new([jx, jy]));
        let gravity = Vector::new([given[0], given[1]]);
        let v = (self.flight).velocity(node.v, impulse, inverse_mass, gravity);
        let (law, node) = (self.contact.of(&given[2..]), Particle { v, ..node });
        let node = G::drift::<C, R, 2>(&self.ground, &law, &self.flight.drift, node);
        node.array()
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 7, 4, M>) -> [[R; 7]; M] {
        G::flying_vjp(self, at)
    }
}

/// The kernel of a drift without a push. It maps `[x, y, vx, vy]` to the new `[x, y, vx, vy]`. The uniform inputs are
/// the law's settings.
#[derive(Clone, Debug)]
pub struct Drifting<C, G = Flat> {
    /// The duration of the drift.
    pub drift: Drift,
    /// The contact law.
    pub contact: C,
    /// The ground.
    pub ground: G,
}

#[kernel]
impl<C: Contact, G: Surface> Kernel<4, 4> for Drifting<C, G> {
    const UNIFORMS: usize = C::COUNT;
    const COMPILED: bool = false;

    fn eval<R: Real>(&self, node: [R; 4], settings: &[R]) -> [R; 4] {
        let (law, node) = (self.contact.of(settings), Particle::new(node));
        let node = G::drift::<C, R, 2>(&self.ground, &law, &self.drift, node);
        node.array()
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 4, 4, M>) -> [[R; 4]; M] {
        G::drifting_vjp(self, at)
    }
}
