//! Contact in an implicit step: nodes that touch the ground are held while the velocities are solved for, so that bars
//! feel the ground in the same step.
//!
//! A step solves once or more; each time is a *pass*. Before a pass, the kernels of this file decide which nodes are held,
//! which of these stick, and how friction brakes the others. After the last pass, the nodes move. The choices have no
//! derivative; everything else has one. `tests/data/implicit/README.md` explains the algorithm, and why it is as it is.

use autodiff::arrays::{constants, pulled_back, seeded};
use autodiff::{Kernel, Pullback, Real};

use super::contact::{Contact, Impact, OverGround, Surface};
use super::motion::{Drift, Particle};
use super::terrain::NONE;
use crate::geometry::{Plane, Rotation, Symmetric, Vector};
use crate::kernel;

/// The drag of friction is at most this many times the trace of the node's block of the matrix.
const STICKIEST: f64 = 1e8;

/// Above this ratio of friction to normal impulse, friction counts as infinite: a held node sticks.
const INFINITE: f64 = 1e3;

/// The smallest speed by which friction is divided, m/s. It is a normal number in single precision too.
const LEAST: f64 = 1e-30;

/// The speed along the ground below which a node that meets the ground rests, m/s. A node that stuck has exactly 0; rounding
/// must not turn such a node into one that slides.
const REST: f64 = 1e-6;

/// The contacts of all nodes in a pass. Every field has a number for each node. Yes is 1, and no is 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeContacts<A> {
    pub(crate) ground: GroundBelow<A>,
    /// Whether the node is held: it cannot move into the ground or off it.
    pub(crate) is_held: A,
    /// Whether the node is also held along the ground.
    pub(crate) sticks: A,
    /// The time from the beginning of the step until the node meets the ground, s.
    pub(crate) impact: A,
    /// The mean velocity along the ground, m/s, of a node that stops there at the impact.
    pub(crate) slip: A,
    /// The drag of friction, kg: it gives the node the impulse `-drag (v - slip)` along the ground.
    pub(crate) drag: A,
    /// The speed, m/s, from which friction slows down a node that slid in the pass before; else 0.
    pub(crate) slid: A,
}

/// The ground below a node in a pass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GroundBelow<A> {
    /// The number of the ground's segment that the node touches.
    pub(crate) segment: A,
    /// Whether the node meets the ground in this step and was not held before.
    pub(crate) is_new: A,
    /// The unit vector along the segment.
    pub(crate) tangent: Vector<A, 2>,
    /// The height of the node above the segment, m.
    pub(crate) height: A,
}

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
    const UNIFORMS: usize = C::COUNT;

    fn eval<R: Real>(&self, _: [R; 1], settings: &[R]) -> [R; 1] {
        [C::grip(&self.0.of(settings))]
    }
}

/// The kernel that finds the ground below a node, as the numbers of [`GroundBelow`]. The inputs are the position, the velocity in
/// the step, and of the pass before the segment and `is_held`. Only the height has a derivative.
#[derive(Clone, Debug)]
pub(crate) struct FindGround<G> {
    pub(crate) ground: G,
    /// The duration of the step, s.
    pub(crate) dt: f64,
}

#[kernel]
impl<G: Surface> Kernel<6, 5> for FindGround<G> {
    fn eval<R: Real>(&self, [x, y, wx, wy, segment, is_held]: [R; 6], _: &[R]) -> [R; 5] {
        let node = Particle::split(&[x, y, wx, wy]).0;
        let (meets, met) = self.ground.meets(node, self.dt);
        let is_new = meets & !mask(is_held);
        let segment = R::select(is_new, met, segment).detach();
        let found = [segment, truth(is_new)];
        below(found, self.ground.plane(segment), node.x)
    }

    // The search runs without tangents, because it has no derivative.
    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 6, 5, M>) -> [[R; 6]; M] {
        let [segment, is_new, ..] = at.y;
        let ([x, y, ..], plane) = (seeded(at.x), self.ground.plane(segment).constant());
        let found = constants(&[segment, is_new]);
        pulled_back(below(found, plane, Vector::new([x, y])), at.y_bar)
    }
}

/// The numbers of [`GroundBelow`]: the segment and whether the node is new there, the tangent of the plane of the segment, and
/// the height of the node above it.
#[inline(always)]
fn below<R: Real>([segment, is_new]: [R; 2], plane: Plane<R>, x: Vector<R, 2>) -> [R; 5] {
    let along = Vector::upright(R::one(), R::zero());
    let [tx, ty] = plane.axes.out_of_rotated(along).array();
    [segment, is_new, tx, ty, plane.height(x)]
}

/// A node in a pass, seen from the ground below it. Components of vectors are along the ground and out of it.
struct LocalNode<R: Real> {
    axes: Rotation<R>,
    height: R,
    /// The velocity in the step, m/s.
    moving: Vector<R, 2>,
    /// The time until the impact, s, if the node meets the ground.
    impact: R,
}

impl<R: Real> LocalNode<R> {
    /// `moving` is in the ground's frame. The step takes `dt` seconds.
    #[inline(always)]
    fn new(
        tangent: Vector<R, 2>,
        height: R,
        is_new: R::Mask,
        moving: Vector<R, 2>,
        dt: f64,
    ) -> Self {
        let axes = Rotation::with_tangent(tangent);
        let moving = axes.into_rotated(moving);
        let approach = R::select(is_new, moving.up(), -R::one());
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
    fn correction(&self, is_held: R::Mask, sticks: R::Mask, slip: R, dt: f64) -> Vector<R, 2> {
        let (zero, moving) = (R::zero(), self.moving);
        let landing = -(self.height.max(zero)) / R::lit(dt);
        self.axes.out_of_rotated(Vector::upright(
            R::select(sticks, slip - moving.forward(), zero),
            R::select(is_held, landing - moving.up(), zero),
        ))
    }

    /// Whether a node that meets the ground rests there: before, it moved along the ground more slowly than [`REST`].
    #[inline(always)]
    fn rests(&self, v: Vector<R, 2>, grip: R) -> R::Mask {
        let along = self.axes.into_rotated(v).forward();
        along.abs().less(R::lit(REST)) & R::zero().less(grip)
    }
}

/// The kernel of the first pass. The inputs are the velocity, the velocity with which the node would move without bars, and
/// of the ground below it whether the node is newly held, the tangent and the height (m). The uniform input is the
/// [grip](Contact::grip). The results are whether the node sticks, its time of impact (s) and its slip (m/s), and the change of velocity of held nodes.
#[derive(Clone, Debug)]
pub struct FirstPass {
    /// The duration of the step, s.
    pub dt: f64,
}

#[kernel]
impl Kernel<8, 5> for FirstPass {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(
        &self,
        [vx, vy, wx, wy, is_new, tx, ty, height]: [R; 8],
        given: &[R],
    ) -> [R; 5] {
        let (v, moving, meets) = (Vector::new([vx, vy]), Vector::new([wx, wy]), mask(is_new));
        let local = LocalNode::new(Vector::new([tx, ty]), height, meets, moving, self.dt);
        // A node that lands or slides is free along the ground in this pass, so that a false stop does not spoil its
        // reaction.
        let rests = meets & local.rests(v, given[0]);
        let slip = local.impact / R::lit(self.dt) * local.moving.forward();
        let slip = R::select(meets & !rests, slip, R::zero());
        let [ex, ey] = local.correction(meets, rests, slip, self.dt).array();
        let impact = R::select(meets, local.impact, R::zero());
        [truth(rests), impact, slip, ex, ey]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 8, 5, M>) -> [[R; 8]; M] {
        self.emitted_vjp(at)
    }
}

/// The kernel of the later passes. The inputs are those of [`FirstPass`], where the second vector is the velocity of the
/// pass before. Then come 1 / mass, and from the pass before: whether the node was held, stuck, and newly held, its time of
/// impact (s), its slip (m/s), and the impulse that the ground gave it (N s); at last the node's block of the matrix of bars
/// in the first pass (kg). The results are whether the node is held and sticks, its time of impact, its slip, the drag of
/// friction (kg), the speed from which friction slows it down (m/s), and the change of velocity of held nodes.
#[derive(Clone, Debug)]
pub struct NextPass {
    /// The duration of the step, s.
    pub dt: f64,
}

#[kernel]
impl Kernel<19, 8> for NextPass {
    const UNIFORMS: usize = 1;

    fn eval<R: Real>(&self, input: [R; 19], given: &[R]) -> [R; 8] {
        let [vx, vy, wx, wy, is_new, tx, ty, height, rest @ ..] = input;
        let [
            inverse_mass,
            is_held,
            sticks,
            was_new,
            impact,
            slip,
            rest @ ..,
        ] = rest;
        let [jx, jy, xx, xy, yy] = rest;
        let (zero, one, least, dt) = (R::zero(), R::one(), R::lit(LEAST), R::lit(self.dt));
        let (v, moving, tangent) = (
            Vector::new([vx, vy]),
            Vector::new([wx, wy]),
            Vector::new([tx, ty]),
        );
        let (grip, is_new, was_new) = (given[0], mask(is_new), mask(was_new));
        let (was_held, stuck, infinite) =
            (mask(is_held), mask(sticks), R::lit(INFINITE).less(grip));
        let local = LocalNode::new(tangent, height, is_new, moving, self.dt);
        let along = local.moving.forward();

        // A held node stays as long as the ground pushes it; others are held if they would end in the ground.
        let reaction = local.axes.into_rotated(Vector::new([jx, jy]));
        let stays = was_held & zero.less(reaction.up());
        let held = stays | is_new;
        let rests = is_new & local.rests(v, grip);
        let impact = R::select(is_new, local.impact, impact);
        let lands = (is_new | was_new) & !stuck & !rests;
        let slip = R::select(lands, impact / dt * along, slip);
        let speed = (along - slip).abs();

        // Friction: at most `grip` times the impulse out of the ground. A new node has no such impulse yet, so that of its
        // own mass counts.
        let (pushes, brakes) = (grip * reaction.up().max(zero), reaction.forward().abs());
        let slips = stays & stuck & !infinite & pushes.less(brakes);
        let slides = stays & !stuck;
        let own = grip * local.moving.up().abs() / inverse_mass * (one - local.impact / dt);
        let slowest = R::select(speed.less(least), least, speed);
        let drag = R::select(is_new, own, pushes) / slowest;
        let drag = R::select(slides | is_new, drag, zero);
        let (bars, mass) = (Symmetric::new([xx, xy, yy]), inverse_mass.recip());
        let inertia = mass + tangent.dot(bars * tangent);
        let excess = R::select(slips, brakes - pushes, one);
        let drag = R::select(slips, pushes * inertia / excess, drag);
        let most = (R::lit(STICKIEST) * (bars.trace() + mass + mass)).detach();
        let drag = R::select(drag.less(most), drag, most);
        let sticks = (infinite & held) | (stays & stuck & !slips) | rests;
        let [ex, ey] = local.correction(held, sticks, slip, self.dt).array();
        [
            truth(held),
            truth(sticks),
            impact,
            slip,
            R::select(infinite, zero, drag),
            R::select(slides, speed, zero),
            ex,
            ey,
        ]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 19, 8, M>) -> [[R; 19]; M] {
        self.emitted_vjp(at)
    }
}

/// The kernel of a node's equation. The inputs are the change of velocity of held nodes, the velocity at the base of the
/// linearisation, the velocity without bars, the impulse of the forces (N s), 1 / mass, the tangent of the ground, whether
/// the node is held and sticks, its slip (m/s) and the drag of friction (kg). The results are the right-hand side (N s),
/// the node's block of the matrix (kg), and the projection onto its held directions.
#[derive(Clone, Copy, Debug)]
pub struct Equation;

#[kernel]
impl Kernel<15, 8> for Equation {
    fn eval<R: Real>(&self, input: [R; 15], _: &[R]) -> [R; 8] {
        let [
            ex,
            ey,
            vx,
            vy,
            fx,
            fy,
            jx,
            jy,
            inverse_mass,
            tx,
            ty,
            rest @ ..,
        ] = input;
        let [is_held, sticks, slip, drag] = rest;
        let (tangent, free) = (Vector::new([tx, ty]), Vector::new([fx, fy]));
        let moving = Vector::new([vx, vy]) + Vector::new([ex, ey]);
        let unexplained = residual(moving, free, Vector::new([jx, jy]), inverse_mass);
        let slides = tangent.dot(moving) - slip;
        let [bx, by] = (-(unexplained + tangent * (drag * slides))).array();
        let mass = inverse_mass.recip();
        let [xx, xy, yy] = Symmetric::scaling(tangent, mass + drag, mass).array();
        let [fxx, fxy, fyy] = Symmetric::scaling(tangent, sticks, is_held).array();
        [bx, by, xx, xy, yy, fxx, fxy, fyy]
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 15, 8, M>) -> [[R; 15]; M] {
        self.emitted_vjp(at)
    }
}

/// The impulse (N s) that bars do not explain if a node moves with the velocity `moving`, and with `free` without bars.
#[inline(always)]
fn residual<R: Real>(
    moving: Vector<R, 2>,
    free: Vector<R, 2>,
    impulse: Vector<R, 2>,
    inverse_mass: R,
) -> Vector<R, 2> {
    (moving - free) / inverse_mass - impulse
}

/// The kernel of a node's [`Equation`] in a world without ground. The inputs are its third to its ninth; the results
/// are the right-hand side and the block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeEquation;

#[kernel]
impl Kernel<7, 5> for FreeEquation {
    fn eval<R: Real>(&self, [vx, vy, fx, fy, jx, jy, inverse_mass]: [R; 7], _: &[R]) -> [R; 5] {
        let reaction = Reaction.eval([vx, vy, fx, fy, jx, jy, inverse_mass], &[]);
        let mass = inverse_mass.recip();
        [-reaction[0], -reaction[1], mass, R::zero(), mass]
    }
}

/// The kernel of the impulse (N s) that the ground must give a node. The inputs are its velocity in the step, the velocity
/// without bars, the impulse of the forces, and 1 / mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction;

#[kernel]
impl Kernel<7, 2> for Reaction {
    fn eval<R: Real>(&self, [wx, wy, fx, fy, jx, jy, inverse_mass]: [R; 7], _: &[R]) -> [R; 2] {
        let (moving, free) = (Vector::new([wx, wy]), Vector::new([fx, fy]));
        residual(moving, free, Vector::new([jx, jy]), inverse_mass).array()
    }
}

/// The kernel that ends a step. The inputs are the position, the velocity in the step, and of the [`NodeContacts`] the segment,
/// `is_held`, `sticks`, `slip` and `slid`. The results are the new position and velocity. The uniform inputs are the
/// settings of the contact law.
///
/// The contact law takes the rest of a held node's velocity into the ground. A node that is not held and still meets the
/// ground gets the contact law as in an explicit step, as does a held node that runs into another segment.
#[derive(Clone, Debug)]
pub(super) struct Landing<C, G> {
    pub(super) contact: C,
    pub(super) ground: G,
    /// The duration of the step, s.
    pub(super) dt: f64,
}

#[kernel]
impl<C: Contact, G: Surface> Kernel<9, 4> for Landing<C, G> {
    const UNIFORMS: usize = C::COUNT;

    fn eval<R: Real>(&self, x: [R; 9], settings: &[R]) -> [R; 4] {
        let (law, node, but) = self.before(x, settings);
        let end = (self.ground).drift_but::<C, R, 2>(&law, &self.drift(), node, but);
        self.after(&law, x, self.ground.plane(but).axes, end)
    }

    fn vjp<R: Real, const M: usize>(&self, at: Pullback<R, 9, 4, M>) -> [[R; 9]; M] {
        self.ground.vjp(self, at)
    }
}

impl<C: Contact, G: Surface> OverGround<C, 9> for Landing<C, G> {
    #[inline(always)]
    fn drift(&self) -> Drift {
        Drift { dt: self.dt }
    }

    #[inline(always)]
    fn before<R: Real>(
        &self,
        [x, y, wx, wy, segment, is_held, ..]: [R; 9],
        settings: &[R],
    ) -> (C::Of<R>, Particle<R, 2>, R) {
        let but = R::select(mask(is_held), segment, R::lit(NONE));
        let (law, node) = (
            self.contact.of(settings),
            Particle::split(&[x, y, wx, wy]).0,
        );
        (law, node, but)
    }

    #[inline(always)]
    fn after<R: Real>(
        &self,
        law: &C::Of<R>,
        [_, _, wx, wy, _, is_held, sticks, slip, slid]: [R; 9],
        axes: Rotation<R>,
        end: Particle<R, 2>,
    ) -> [R; 4] {
        let (v, zero, rest) = (Vector::new([wx, wy]), R::zero(), R::lit(self.dt));
        let turned = end.v - v;
        let again = zero.less(turned.forward().abs() + turned.up().abs());
        let velocity = axes.into_rotated(v);
        let braked = axes.out_of_rotated(C::respond(law, Impact { velocity, rest }));
        // Coulomb friction would have stopped a node that the drag has slowed down by more than half.
        let half = R::lit(0.5) * slid;
        let stops = mask(sticks) | (velocity.forward() - slip).abs().less(half);
        let resting = Vector::select(stops, Vector::zero(), braked);
        let v = Vector::select(mask(is_held) & !again, resting, end.v);
        Particle { x: end.x, v }.array()
    }
}
