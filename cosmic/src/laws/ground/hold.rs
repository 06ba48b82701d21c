//! Contact in an implicit step: nodes that touch the ground are held while the velocities are solved for, so that bars
//! feel the ground in the same step.
//!
//! A step solves once or more; each time is a *pass*. Before a pass, the kernels of this file decide which nodes are held,
//! which of these stick, and how friction brakes the others. After the last pass, the nodes move. The choices have no
//! derivative; everything else has one. `tests/data/implicit/README.md` explains the algorithm, and why it is as it is.

use autodiff::{Dual, Real};
use autodiff_programs::kernels::{pulled_back, seeded};
use autodiff_programs::{Compiled, Fields, Kernel, Pullback};

use super::contact::{Contact, Impact, OverGround, Surface};
use super::pass::{
    Balance, FirstContact, GroundBelow, HeldEquation, HeldNode, LandingNode, Meeting, NextContact,
    NodeAndGround, NodeEquation, NodeInNextPass, NodeInPass,
};
use super::terrain::NONE;
use crate::geometry::{Along, Plane, Rotation, Symmetric, Vector};
use crate::laws::motion::{Drift, Particle};
use crate::{in_both_dimensions, kernel};

/// The drag of friction is at most this many times the trace of the node's block of the matrix.
const STICKIEST: f64 = 1e8;

/// Above this ratio of friction to normal impulse, friction counts as infinite: a held node sticks.
const INFINITE: f64 = 1e3;

/// The smallest speed by which friction is divided, m/s. It is a normal number in single precision too.
const LEAST: f64 = 1e-30;

/// The speed along the ground below which a node that meets the ground rests, m/s. A node that stuck has exactly 0; rounding
/// must not turn such a node into one that slides.
const REST: f64 = 1e-6;

/// The number of a mask: 1 for yes, 0 for no.
#[inline(always)]
fn truth<R: Real>(mask: R::Mask) -> R {
    R::select(mask, R::one(), R::zero())
}

/// The mask of a number that is 1 for yes and 0 for no.
#[inline(always)]
fn mask<R: Real>(number: R) -> R::Mask {
    R::lit(0.5).less(number)
}

/// The largest friction of a contact law, as a multiple of the normal impulse: a velocity along the ground that is too
/// large to be stopped loses as much as friction can take.
///
/// The uniform inputs are the law's settings. The input is not read.
#[derive(Clone, Debug)]
pub(super) struct Grip<C>(pub(super) C);

#[kernel]
impl<C: Contact> Kernel<1, 1> for Grip<C> {
    const COMPILED: Compiled = C::COMPILED.at_most(Compiled::Seldom);
    const UNIFORMS: usize = C::COUNT;

    fn eval<R: Real>(&self, _: [R; 1], settings: &[R]) -> [R; 1] {
        [C::grip(&self.0.of(settings))]
    }
}

/// The kernel that finds the ground below a node. Only the height has a derivative.
#[derive(Clone, Debug)]
pub(crate) struct FindGround<G, const D: usize> {
    pub(crate) ground: G,
    /// The duration of the step, s.
    pub(crate) dt: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl<G: Surface> Kernel<_, _> for FindGround<G, D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, before: NodeAndGround<R, D>, _: &[R]) -> GroundBelow<R> {
            let (meets, met) = self.ground.meets(before.node, self.dt);
            let is_new = meets & !mask(before.is_held);
            let segment = R::select(is_new, met, before.segment).detach();
            below([segment, truth(is_new)], self.ground.plane(segment), before.node.x)
        }

        // The search runs without tangents, because it has no derivative.
        fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
            let GroundBelow { segment, meeting } = GroundBelow::of(at.y);
            let plane = self.ground.plane(segment).constant();
            let NodeAndGround { node, .. } = NodeAndGround::<_, D>::of(seeded(at.x));
            let found = [Dual::constant(segment), Dual::constant(meeting.is_new)];
            pulled_back(below(found, plane, node.x).array(), at.y_bar)
        }
    }
}

/// The ground below a node: the segment and whether the node is new there, and the plane of the segment.
#[inline(always)]
fn below<R: Real, const D: usize>(
    [segment, is_new]: [R; 2],
    plane: Plane<R>,
    x: Vector<R, D>,
) -> GroundBelow<R> {
    let along = Vector::<R, 2>::upright(R::one(), R::zero());
    let meeting = Meeting {
        is_new,
        tangent: plane.axes.out_of_rotated(along),
        height: plane.height(x),
    };
    GroundBelow { segment, meeting }
}

/// A node in a pass, seen from the ground below it. Components of vectors are along the ground and out of it.
struct LocalNode<R: Real, const D: usize> {
    axes: Rotation<R>,
    height: R,
    /// The velocity in the step, m/s.
    moving: Vector<R, D>,
    /// The time until the impact, s, if the node meets the ground.
    impact: R,
}

impl<R: Real, const D: usize> LocalNode<R, D> {
    /// `moving` is in the ground's frame. The step takes `dt` seconds.
    #[inline(always)]
    fn new(meeting: Meeting<R>, moving: Vector<R, D>, dt: f64) -> Self {
        let (axes, height) = (Rotation::with_tangent(meeting.tangent), meeting.height);
        let moving = axes.into_rotated(moving);
        let approach = R::select(mask(meeting.is_new), moving.up(), -R::one());
        Self {
            axes,
            height,
            moving,
            impact: (-height / approach).clamp(R::zero(), R::lit(dt)),
        }
    }

    /// The change of velocity, m/s, that brings a held node to the ground in `dt` seconds, and a node that sticks to the
    /// velocity `slip`. It is in the ground's frame.
    #[inline(always)]
    fn correction(
        &self,
        is_held: R::Mask,
        sticks: R::Mask,
        slip: Vector<R, D>,
        dt: f64,
    ) -> Vector<R, D> {
        let (zero, moving) = (R::zero(), self.moving);
        let landing = -(self.height.max(zero)) / R::lit(dt);
        let along = Vector::select(sticks, slip - moving, Vector::zero());
        let up = R::select(is_held, landing - moving.up(), zero);
        self.axes.out_of_rotated(along.with_up(up))
    }

    /// Whether a node that meets the ground rests there: before, it moved along the ground more slowly than [`REST`].
    #[inline(always)]
    fn rests(&self, v: Vector<R, D>, grip: R) -> R::Mask {
        let speed = self.axes.into_rotated(v).norm_along();
        speed.less(R::lit(REST)) & R::zero().less(grip)
    }
}

/// The unit vector in the direction of a vector along the ground of this length, which is given by its components along the
/// ground. In the plane, it is the tangent, whatever the sign.
#[inline(always)]
fn direction<R: Real, const D: usize>(
    tangent: Vector<R, 2>,
    along: Vector<R, D>,
    length: R,
) -> Vector<R, D> {
    if D == 2 {
        return Vector::upright(tangent.forward(), tangent.up());
    }
    Rotation::with_tangent(tangent).out_of_plane(along.along() / length)
}

/// The kernel of the first pass. The uniform input is the [grip](Contact::grip).
#[derive(Clone, Debug)]
pub struct FirstPass<const D: usize> {
    /// The duration of the step, s.
    pub dt: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for FirstPass<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = 1;

        fn eval<R: Real>(&self, node: NodeInPass<R, D>, given: &[R]) -> FirstContact<R, D> {
            let meets = mask(node.meeting.is_new);
            let local = LocalNode::new(node.meeting, node.moving, self.dt);
            // A node that lands or slides is free along the ground in this pass, so that a false stop does not spoil its
            // reaction.
            let rests = meets & local.rests(node.v, given[0]);
            let slip = local.moving.along() * (local.impact / R::lit(self.dt));
            let slip = Vector::select(meets & !rests, slip, Vector::zero());
            FirstContact {
                sticks: truth(rests),
                impact: R::select(meets, local.impact, R::zero()),
                slip: Along::of(slip),
                change: local.correction(meets, rests, slip, self.dt),
            }
        }

        fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// The kernel of the later passes. The uniform input is the [grip](Contact::grip).
#[derive(Clone, Debug)]
pub struct NextPass<const D: usize> {
    /// The duration of the step, s.
    pub dt: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for NextPass<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = 1;

        fn eval<R: Real>(
            &self,
            given: NodeInNextPass<R, D>,
            uniforms: &[R],
        ) -> NextContact<R, D> {
            let (now, grip) = (given.now, uniforms[0]);
            let (zero, one, least, dt) = (R::zero(), R::one(), R::lit(LEAST), R::lit(self.dt));
            let (is_new, was_new) = (mask(now.meeting.is_new), mask(given.was_new));
            let (was_held, stuck, infinite) =
                (mask(given.was_held), mask(given.stuck), R::lit(INFINITE).less(grip));
            let local = LocalNode::new(now.meeting, now.moving, self.dt);
            let along = local.moving.along();

            // A held node stays as long as the ground pushes it; others are held if they would end in the ground.
            let reaction = local.axes.into_rotated(given.reaction);
            let stays = was_held & zero.less(reaction.up());
            let held = stays | is_new;
            let rests = is_new & local.rests(now.v, grip);
            let impact = R::select(is_new, local.impact, given.impact);
            let lands = (is_new | was_new) & !stuck & !rests;
            let slip = Vector::select(lands, along * (impact / dt), given.slip.vector());
            let speed = (along - slip).norm_along();

            // Friction: at most `grip` times the impulse out of the ground. A new node has no such impulse yet, so that of
            // its own mass counts.
            let (pushes, brakes) = (grip * reaction.up().max(zero), reaction.norm_along());
            let slips = stays & stuck & !infinite & pushes.less(brakes);
            let slides = stays & !stuck;
            let own = grip * local.moving.up().abs() / given.inverse_mass * (one - local.impact / dt);
            let slowest = R::select(speed.less(least), least, speed);
            let drag = R::select(is_new, own, pushes) / slowest;
            let drag = R::select(slides | is_new, drag, zero);
            let (bars, mass) = (given.bars, given.inverse_mass.recip());
            let towards = direction(now.meeting.tangent, reaction, R::select(slips, brakes, one));
            let inertia = mass + towards.dot(bars * towards);
            let excess = R::select(slips, brakes - pushes, one);
            let drag = R::select(slips, pushes * inertia / excess, drag);
            let mut trace = bars.trace();
            for _ in 0..D {
                trace += mass;
            }
            let most = (R::lit(STICKIEST) * trace).detach();
            let drag = R::select(drag.less(most), drag, most);
            let sticks = (infinite & held) | (stays & stuck & !slips) | rests;
            NextContact {
                is_held: truth(held),
                sticks: truth(sticks),
                impact,
                slip: Along::of(slip),
                drag: R::select(infinite, zero, drag),
                slid: R::select(slides, speed, zero),
                change: local.correction(held, sticks, slip, self.dt),
            }
        }

        fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// The kernel of a node's equation.
#[derive(Clone, Copy, Debug)]
pub struct Equation<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for Equation<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, node: HeldNode<R, D>, _: &[R]) -> HeldEquation<R, D> {
            let HeldNode { free, impulse, inverse_mass, tangent, sticks, is_held, drag, .. } = node;
            let (axes, moving) = (Rotation::with_tangent(tangent), node.base + node.change);
            let unexplained = Balance { moving, free, impulse, inverse_mass }.residual();
            let slides = axes.into_rotated(moving).along() - node.slip.vector();
            let braked = axes.out_of_plane(slides * drag);
            let mass = inverse_mass.recip();
            let equation = NodeEquation {
                right: -(unexplained + braked),
                block: Symmetric::of_plane(tangent, mass + drag, mass),
            };
            HeldEquation { equation, held: Symmetric::of_plane(tangent, sticks, is_held) }
        }

        fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// The kernel of a node's [`Equation`] in a world without ground.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeEquation<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for FreeEquation<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, node: Balance<R, D>, _: &[R]) -> NodeEquation<R, D> {
            let (reaction, mass) = (node.residual(), node.inverse_mass.recip());
            NodeEquation { right: -reaction, block: Symmetric::diagonal(mass) }
        }
    }
}

/// The kernel of the impulse (N s) that the ground must give a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<_, _> for Reaction<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, node: Balance<R, D>, _: &[R]) -> Vector<R, D> {
            node.residual()
        }
    }
}

/// The kernel that ends a step: the node after it. The uniform inputs are the settings of the contact law.
///
/// The contact law takes the rest of a held node's velocity into the ground. A node that is not held and still meets the
/// ground gets the contact law as in an explicit step, as does a held node that runs into another segment.
#[derive(Clone, Debug)]
pub(super) struct Landing<C, G, const D: usize> {
    pub(super) contact: C,
    pub(super) ground: G,
    /// The duration of the step, s.
    pub(super) dt: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl<C: Contact, G: Surface> Kernel<_, _> for Landing<C, G, D> {
        const COMPILED: Compiled = C::COMPILED.at_most(Compiled::Seldom);
        const UNIFORMS: usize = C::COUNT;

        fn eval<R: Real>(&self, x: LandingNode<R, D>, settings: &[R]) -> Particle<R, D> {
            let (law, node, but) = self.before(x, settings);
            let drift = Drift { dt: self.dt };
            let end = (self.ground).drift_but::<C, R, D>(&law, &drift, node, but);
            self.after(&law, x, self.ground.plane(but).axes, end)
        }

        fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, _, _, M>) -> [[R; _]; M] {
            self.ground.vjp(self, at)
        }
    }
}

impl<C: Contact, G: Surface, const D: usize> OverGround<D> for Landing<C, G, D> {
    type Law = C;
    type Node<R: Real> = LandingNode<R, D>;

    #[inline(always)]
    fn drift(&self) -> Drift {
        Drift { dt: self.dt }
    }

    #[inline(always)]
    fn before<R: Real>(
        &self,
        node: LandingNode<R, D>,
        settings: &[R],
    ) -> (C::Of<R>, Particle<R, D>, R) {
        let but = R::select(mask(node.is_held), node.segment, R::lit(NONE));
        (self.contact.of(settings), node.node, but)
    }

    #[inline(always)]
    fn after<R: Real>(
        &self,
        law: &C::Of<R>,
        node: LandingNode<R, D>,
        axes: Rotation<R>,
        end: Particle<R, D>,
    ) -> Particle<R, D> {
        let (v, zero, rest) = (node.node.v, R::zero(), R::lit(self.dt));
        let again = zero.less((end.v - v).sum_of_sizes());
        let velocity = axes.into_rotated(v);
        let braked = axes.out_of_rotated(C::respond(law, Impact { velocity, rest }));
        // Coulomb friction would have stopped a node that the drag has slowed down by more than half.
        let half = R::lit(0.5) * node.slid;
        let slides = velocity - node.slip.vector();
        let stops = mask(node.sticks) | slides.norm_along().less(half);
        let resting = Vector::select(stops, Vector::zero(), braked);
        let v = Vector::select(mask(node.is_held) & !again, resting, end.v);
        Particle { x: end.x, v }
    }
}
