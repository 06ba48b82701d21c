//! Contact laws: they determine the velocity of a node after it has met the ground.

use std::fmt::Debug;

use autodiff::Real;
use autodiff_programs::kernels::{MOST_UNIFORMS, constants, pulled_back, seeded, vjp_by_duals};
use autodiff_programs::{Compiled, Kernel, Pullback};

use super::terrain::{IMPACTS, NONE, RemainingDrift, Route, Terrain};
use crate::geometry::{Plane, Rotation, Vector, explicit_in};
use crate::laws::law::Law;
use crate::laws::motion::{Drift, Particle, Push};
use crate::settings::StepInputs;
use crate::{Fields, kernel};

/// A node at the moment when it meets the ground.
#[derive(Clone, Copy, Debug)]
pub struct Impact<R, const D: usize> {
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

    /// The adjoint of the kernel [`Flying`] over flat ground. The default works for every law; a
    /// [generated](autodiff_programs::emit) adjoint is faster.
    #[doc(hidden)]
    #[inline(always)]
    fn flying_vjp<R: Real, const M: usize>(
        flying: &Flying<Self>,
        at: Pullback<R, 7, 4, M>,
    ) -> [[R; 7]; M] {
        vjp_by_duals(flying, at)
    }

    /// Like [`flying_vjp`](Self::flying_vjp), in space.
    #[doc(hidden)]
    #[inline(always)]
    fn flying_vjp_in_space<R: Real, const M: usize>(
        flying: &Flying<Self, Flat, 3>,
        at: Pullback<R, 10, 6, M>,
    ) -> [[R; 10]; M] {
        vjp_by_duals(flying, at)
    }
}

/// Computes the node after a drift over terrain, on the given route. If the node meets a segment, the law gets the
/// components of the velocity along that segment and out of it. If the rest of the drift leads into another segment, as in
/// a corner, the law is applied a second time. If the node would sink into the ground even then, it stops in the corner.
#[inline(always)]
fn drift_over<C: Contact, R: Real, const D: usize>(
    law: &C::Of<R>,
    route: &mut impl Route<R>,
    drift: &Drift,
    node: Particle<R, D>,
) -> Particle<R, D> {
    let (node, left) = (route.beside_walls(node), R::lit(drift.dt));
    let mut way = RemainingDrift { node, left };
    for _ in 0..IMPACTS {
        let hit = route.meet(&way);
        let RemainingDrift { node, left } = hit.reached(&way);
        let node = route.beside_walls(node);
        let impact = Impact {
            velocity: node.v,
            rest: left,
        };
        let after = C::respond(law, impact);
        let v = Vector::select(hit.touches, hit.in_ground(after), way.node.v);
        way = RemainingDrift {
            node: Particle { x: node.x, v },
            left,
        };
    }
    let stops = route.meet(&way).touches;
    let v = Vector::select(stops, Vector::zero(), way.node.v);
    Particle { v, ..way.node }.after(way.left)
}

/// Defines the method of an `impl` of [`Contact`] that calls the generated adjoint of the law.
macro_rules! emitted_adjoints {
    () => {
        #[inline(always)]
        fn flying_vjp<R: Real, const M: usize>(
            flying: &Flying<Self>,
            at: autodiff_programs::Pullback<R, 7, 4, M>,
        ) -> [[R; 7]; M] {
            flying.emitted_vjp(at)
        }

        #[inline(always)]
        fn flying_vjp_in_space<R: Real, const M: usize>(
            flying: &Flying<Self, $crate::laws::kernels::Flat, 3>,
            at: autodiff_programs::Pullback<R, 10, 6, M>,
        ) -> [[R; 10]; M] {
            flying.emitted_vjp(at)
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

    /// For what the kernel [`Flying`] over this ground is compiled, at most.
    const COMPILED: Compiled;

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

    /// The adjoint of a kernel over this ground.
    #[inline(always)]
    fn vjp<const D: usize, K, R: Real, const I: usize, const O: usize, const M: usize>(
        &self,
        kernel: &K,
        at: Pullback<R, I, O, M>,
    ) -> [[R; I]; M]
    where
        K: OverGround<D> + Kernel<I, O>,
    {
        vjp_by_duals(kernel, at)
    }

    /// The adjoint of the kernel [`Flying`] over this ground.
    #[inline(always)]
    fn flying_vjp<C: Contact, R: Real, const M: usize>(
        flying: &Flying<C, Self>,
        at: Pullback<R, 7, 4, M>,
    ) -> [[R; 7]; M] {
        flying.ground.vjp(flying, at)
    }
}

/// A kernel that moves nodes over the ground: what it computes before and after their drift.
pub trait OverGround<const D: usize> {
    /// The contact law.
    type Law: Contact;
    /// The inputs of the kernel.
    type Node<R: Real>: Fields<R> + Copy;

    /// The drift.
    fn drift(&self) -> Drift;

    /// The contact law, the node at the beginning of the drift, and the number of the segment that it does not meet; -1 for
    /// none.
    fn before<R: Real>(
        &self,
        node: Self::Node<R>,
        given: &[R],
    ) -> (<Self::Law as StepInputs>::Of<R>, Particle<R, D>, R);

    /// The results of the kernel. `axes` are those of the segment that the node does not meet, and `end` is the node at the
    /// end of the drift.
    fn after<R: Real>(
        &self,
        law: &<Self::Law as StepInputs>::Of<R>,
        node: Self::Node<R>,
        axes: Rotation<R>,
        end: Particle<R, D>,
    ) -> Particle<R, D>;
}

/// A flat ground line. It is also used if there is no ground.
#[derive(Clone, Copy, Debug)]
pub struct Flat;

#[kernel]
impl Surface for Flat {
    const COMPILED: Compiled = explicit_in(2);

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
}

#[kernel]
impl Surface for Terrain {
    const COMPILED: Compiled = Compiled::Narrow;

    fn drift<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
    ) -> Particle<R, D> {
        drift_over::<C, R, D>(law, &mut self.search(R::lit(NONE)), drift, node)
    }

    fn drift_but<C: Contact, R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        drift: &Drift,
        node: Particle<R, D>,
        but: R,
    ) -> Particle<R, D> {
        drift_over::<C, R, D>(law, &mut self.search(but), drift, node)
    }

    fn meets<R: Real, const D: usize>(&self, node: Particle<R, D>, dt: f64) -> (R::Mask, R) {
        let (mut search, left) = (self.search(R::lit(NONE)), R::lit(dt));
        let node = search.beside_walls(node);
        let hit = search.meet(&RemainingDrift { node, left });
        (hit.touches, hit.segment)
    }

    fn plane<R: Real>(&self, segment: R) -> Plane<R> {
        self.plane_of(segment)
    }

    // The search runs without tangents, because it has no derivative.
    fn vjp<const D: usize, K, R: Real, const I: usize, const O: usize, const M: usize>(
        &self,
        kernel: &K,
        at: Pullback<R, I, O, M>,
    ) -> [[R; I]; M]
    where
        K: OverGround<D> + Kernel<I, O>,
    {
        let (drift, x) = (kernel.drift(), K::Node::of(at.x));
        let (law, node, but) = kernel.before(x, at.uniforms);
        let (mut search, axes) = (self.search(but), self.plane_of(but).axes);
        drift_over::<K::Law, R, D>(&law, &mut search, &drift, node);
        let given = constants::<R, I, MOST_UNIFORMS>(at.uniforms);
        let x = K::Node::of(seeded(at.x));
        let (law, node, _) = kernel.before(x, &given[..at.uniforms.len()]);
        let end = drift_over::<K::Law, _, D>(&law, &mut search.found(), &drift, node);
        let results = kernel.after(&law, x, axes.constant(), end);
        pulled_back(results.array(), at.y_bar)
    }
}

/// A node at the beginning of a step.
#[derive(Clone, Copy, Debug, Fields)]
pub struct PushedNode<T, const D: usize> {
    /// The position and the velocity.
    pub node: Particle<T, D>,
    /// The impulse that the node gets, N s.
    pub impulse: Vector<T, D>,
    /// 1 / mass, 1/kg.
    pub inverse_mass: T,
}

/// The kernel of one step of a node: a push that changes the velocity, then a drift that changes the position. It maps a
/// [`PushedNode`] to the node after the step. The uniform inputs are those of a [`Push`], then the law's settings.
#[derive(Clone, Debug)]
pub struct Flying<C, G = Flat, const D: usize = 2> {
    /// The drift after the push.
    pub drift: Drift,
    /// The contact law.
    pub contact: C,
    /// The ground.
    pub ground: G,
}

impl<C: Contact, G: Surface, const D: usize> Flying<C, G, D> {
    /// The settings of the law, and the node after the push.
    #[inline(always)]
    fn pushed<R: Real>(
        &self,
        PushedNode {
            node: Particle { x, v },
            impulse,
            inverse_mass,
        }: PushedNode<R, D>,
        given: &[R],
    ) -> (C::Of<R>, Particle<R, D>) {
        let v = Push::of(given).velocity(v, impulse, inverse_mass);
        let law = self.contact.of(&given[Push::<R, D>::COUNT..]);
        (law, Particle { x, v })
    }

    #[inline(always)]
    fn flown<R: Real>(&self, node: PushedNode<R, D>, given: &[R]) -> Particle<R, D> {
        let (law, node) = self.pushed(node, given);
        G::drift::<C, R, D>(&self.ground, &law, &self.drift, node)
    }
}

#[kernel]
impl<C: Contact, G: Surface> Kernel<_, _> for Flying<C, G> {
    const COMPILED: Compiled = C::COMPILED.at_most(G::COMPILED);
    const UNIFORMS: usize = Push::<f64, 2>::COUNT + C::COUNT;

    fn eval<R: Real>(&self, node: PushedNode<R, 2>, given: &[R]) -> Particle<R, 2> {
        self.flown(node, given)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
        G::flying_vjp(self, at)
    }
}

#[kernel]
impl<C: Contact> Kernel<_, _> for Flying<C, Flat, 3> {
    const COMPILED: Compiled = C::COMPILED.at_most(explicit_in(3));
    const UNIFORMS: usize = Push::<f64, 3>::COUNT + C::COUNT;

    fn eval<R: Real>(&self, node: PushedNode<R, 3>, given: &[R]) -> Particle<R, 3> {
        self.flown(node, given)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
        C::flying_vjp_in_space(self, at)
    }
}

impl<C: Contact, G: Surface> OverGround<2> for Flying<C, G> {
    type Law = C;
    type Node<R: Real> = PushedNode<R, 2>;

    #[inline(always)]
    fn drift(&self) -> Drift {
        self.drift
    }

    #[inline(always)]
    fn before<R: Real>(
        &self,
        node: PushedNode<R, 2>,
        given: &[R],
    ) -> (C::Of<R>, Particle<R, 2>, R) {
        let (law, node) = self.pushed(node, given);
        (law, node, R::lit(NONE))
    }

    #[inline(always)]
    fn after<R: Real>(
        &self,
        _: &C::Of<R>,
        _: PushedNode<R, 2>,
        _: Rotation<R>,
        end: Particle<R, 2>,
    ) -> Particle<R, 2> {
        end
    }
}
