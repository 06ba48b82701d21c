//! Contact in an implicit step: nodes that touch the ground are held while the velocities are solved for, so that bars
//! feel the ground in the same step.
//!
//! A step solves once or more; each time is a *pass*. Before a pass, the kernels of this file decide which nodes are held,
//! which of these stick, and how friction brakes the others. After the last pass, the nodes move. The choices have no
//! derivative; everything else has one. `tests/data/implicit/README.md` explains the algorithm, and why it is as it is.

use autodiff::arrays::{UniformKernel, Uniforms};
use autodiff::{Kernel, Real};

use super::contact::{Contact, Impact, Underfoot};
use super::motion::{Drift, Particle};
use super::terrain::NONE;
use crate::geometry::{Plane, Symmetric, Vector};

/// The drag of friction is at most this many times the trace of the node's block of the matrix.
const STICKIEST: f64 = 1e8;

/// Above this ratio of friction to normal impulse, friction counts as infinite: a held node sticks.
const INFINITE: f64 = 1e3;

/// A speed that counts as 0, m/s. It is a normal number in single precision too.
const REST: f64 = 1e-30;

/// What is known of a node before a pass. `R` is the type of a number; truths are 1 or 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hold<R> {
    /// The number of the ground's segment that the node touches.
    pub(crate) segment: R,
    /// Whether the node is held: it cannot move into the ground or off it.
    pub(crate) is_held: R,
    /// Whether the node is also held along the ground.
    pub(crate) sticks: R,
    /// Whether it is held for the first time in this pass.
    pub(crate) is_new: R,
    /// The time from the beginning of the step until the node meets the ground, s.
    pub(crate) impact: R,
    /// The mean velocity along the ground, m/s, of a node that stops there at the impact.
    pub(crate) slip: R,
    /// The drag of friction, kg: it gives the node the impulse `-drag (v - slip)` along the ground.
    pub(crate) drag: R,
    /// The speed, m/s, from which friction slows down a node that slid in the pass before; else 0.
    pub(crate) slid: R,
}

impl<A: Copy> Hold<A> {
    pub(crate) fn array(self) -> [A; 8] {
        [
            self.segment,
            self.is_held,
            self.sticks,
            self.is_new,
            self.impact,
            self.slip,
            self.drag,
            self.slid,
        ]
    }

    pub(crate) fn new(
        [segment, is_held, sticks, is_new, impact, slip, drag, slid]: [A; 8],
    ) -> Self {
        Self {
            segment,
            is_held,
            sticks,
            is_new,
            impact,
            slip,
            drag,
            slid,
        }
    }
}

/// The true numbers of a mask.
#[inline(always)]
fn truth<R: Real>(mask: R::Mask) -> R {
    R::select(mask, R::one(), R::zero())
}

/// The mask of a number that is 1 or 0.
#[inline(always)]
fn mask<R: Real>(truth: R) -> R::Mask {
    R::lit(0.5).less(truth)
}

/// The largest friction of a contact law, as a multiple of the normal impulse: a velocity along the ground that is too
/// large to be stopped loses as much as friction can take.
///
/// The uniform inputs are the law's settings. The input is not read.
#[derive(Clone, Debug)]
pub(super) struct Grip<C>(pub(super) C);

impl<C: Contact> UniformKernel<1, 1> for Grip<C> {
    const UNIFORMS: usize = C::COUNT;

    #[inline(always)]
    fn eval_with<R: Real>(&self, _: [R; 1], settings: &Uniforms<R>) -> [R; 1] {
        [C::grip(&self.0.of(settings))]
    }
}

/// The ground as it is during a pass, and the duration of the step.
#[derive(Clone, Debug)]
pub(crate) struct Passing<G> {
    pub(crate) ground: G,
    /// The duration of the step, s.
    pub(crate) dt: f64,
}

/// The node at the beginning of a step, the velocity with which it moves in the step, and the ground under it.
struct Over<R: Real> {
    /// The height above the ground, m.
    height: R,
    /// The velocity in the step, m/s: along the ground and out of it.
    moving: Vector<R>,
    /// The time until the impact, s, if the node meets the ground.
    impact: R,
    plane: Plane<R>,
}

impl<G: Underfoot> Passing<G> {
    /// `meets` is true for a node that meets the ground in this step.
    #[inline(always)]
    fn over<R: Real>(
        &self,
        segment: R,
        meets: R::Mask,
        x: Vector<R>,
        moving: Vector<R>,
    ) -> Over<R> {
        let (zero, plane) = (R::zero(), self.ground.plane(segment));
        let (height, moving) = (plane.height(x), plane.axes.into_rotated(moving));
        let approach = R::select(meets, moving.up(), -R::one());
        let impact = (-height / approach).clamp(zero, R::lit(self.dt));
        Over {
            height,
            moving,
            impact,
            plane,
        }
    }

    /// The change of velocity, m/s, that brings a held node to the ground, and a node that sticks to the velocity `slip`.
    #[inline(always)]
    fn correction<R: Real>(&self, over: &Over<R>, hold: &Hold<R>) -> Vector<R> {
        let zero = R::zero();
        let (along, out) = (over.moving.forward(), over.moving.up());
        let landing = -(over.height.max(zero)) / R::lit(self.dt);
        over.plane.axes.out_of_rotated(Vector::upright(
            R::select(mask(hold.sticks), hold.slip - along, zero),
            R::select(mask(hold.is_held), landing - out, zero),
        ))
    }

    /// Whether a node that meets the ground rests there: it did not move along the ground before.
    #[inline(always)]
    fn rests<R: Real>(&self, plane: &Plane<R>, v: Vector<R>, grip: R) -> R::Mask {
        let along = plane.axes.into_rotated(v).forward();
        along.abs().less(R::lit(REST)) & R::zero().less(grip)
    }
}

/// The kernel of the first pass. The inputs are the node (position, velocity) and the velocity with which it would move
/// without bars. The uniform input is the [`Grip`]. The results are the [`Hold`], and the change of velocity of held nodes.
#[derive(Clone, Debug)]
pub(crate) struct FirstPass<G>(pub(crate) Passing<G>);

impl<G: Underfoot> UniformKernel<6, 10> for FirstPass<G> {
    const UNIFORMS: usize = 1;

    #[inline(always)]
    fn eval_with<R: Real>(&self, [x, y, vx, vy, wx, wy]: [R; 6], given: &Uniforms<R>) -> [R; 10] {
        let (x, v, moving) = (
            Vector::new([x, y]),
            Vector::new([vx, vy]),
            Vector::new([wx, wy]),
        );
        let Passing { ground, dt } = &self.0;
        let (meets, segment) = ground.meets(Particle { x, v: moving }, *dt);
        let over = self.0.over(segment, meets, x, moving);
        // A node that lands or slides is free along the ground in this pass, so that a false stop does not spoil its
        // reaction.
        let rests = meets & self.0.rests(&over.plane, v, given[0]);
        let slip = over.impact / R::lit(*dt) * over.moving.forward();
        let hold = Hold {
            segment,
            is_held: truth(meets),
            sticks: truth(rests),
            is_new: truth(meets),
            impact: R::select(meets, over.impact, R::zero()),
            slip: R::select(meets & !rests, slip, R::zero()),
            drag: R::zero(),
            slid: R::zero(),
        };
        let [ex, ey] = self.0.correction(&over, &hold).array();
        let [a, b, c, d, e, f, g, h] = hold.array();
        [a, b, c, d, e, f, g, h, ex, ey]
    }
}

/// The kernel of the later passes. The inputs are those of [`FirstPass`], where the third vector is the velocity of the
/// pass before, then 1 / mass, the first six numbers of the [`Hold`] before, the impulse that the ground gave in the pass
/// before (N s), and the node's block of the matrix of bars in the first pass (kg). The results are those of [`FirstPass`].
#[derive(Clone, Debug)]
pub(crate) struct NextPass<G>(pub(crate) Passing<G>);

impl<G: Underfoot> UniformKernel<18, 10> for NextPass<G> {
    const UNIFORMS: usize = 1;

    #[inline(always)]
    fn eval_with<R: Real>(&self, input: [R; 18], given: &Uniforms<R>) -> [R; 10] {
        let [x, y, vx, vy, wx, wy, inverse_mass, rest @ ..] = input;
        let [
            segment,
            is_held,
            sticks,
            is_new,
            impact,
            slip,
            jx,
            jy,
            xx,
            xy,
            yy,
        ] = rest;
        let (x, v, moving) = (
            Vector::new([x, y]),
            Vector::new([vx, vy]),
            Vector::new([wx, wy]),
        );
        let Passing { ground, dt } = &self.0;
        let (zero, one, least, dt_) = (R::zero(), R::one(), R::lit(REST), R::lit(*dt));
        let (grip, was_held, stuck, was_new) =
            (given[0], mask(is_held), mask(sticks), mask(is_new));
        let infinite = R::lit(INFINITE).less(grip);

        // A held node stays as long as the ground pushes it; others are held if they would end in the ground.
        let (meets, met) = ground.meets(Particle { x, v: moving }, *dt);
        let before = ground
            .plane(segment)
            .axes
            .into_rotated(Vector::new([jx, jy]));
        let stays = was_held & zero.less(before.up());
        let is_new = meets & !was_held;
        let held = stays | is_new;
        let segment = R::select(is_new, met, segment);
        let over = self.0.over(segment, is_new, x, moving);
        let along = over.moving.forward();

        let rests = is_new & self.0.rests(&over.plane, v, grip);
        let impact = R::select(is_new, over.impact, impact);
        let lands = (is_new | was_new) & !stuck & !rests;
        let slip = R::select(lands, impact / dt_ * along, slip);
        let speed = (along - slip).abs();

        // Friction: at most `grip` times the impulse out of the ground. A new node has no such impulse yet, so that of its
        // own mass counts.
        let (pushes, brakes) = (grip * before.up().max(zero), before.forward().abs());
        let slips = stays & stuck & !infinite & pushes.less(brakes);
        let slides = stays & !stuck;
        let own = grip * over.moving.up().abs() / inverse_mass * (one - over.impact / dt_);
        let slowest = R::select(speed.less(least), least, speed);
        let drag = R::select(is_new, own, pushes) / slowest;
        let drag = R::select(slides | is_new, drag, zero);
        let bars = Symmetric::new([xx, xy, yy]);
        let tangent = (over.plane.axes).out_of_rotated(Vector::upright(one, zero));
        let mass = inverse_mass.recip();
        let inertia = mass + tangent.dot(bars * tangent);
        let excess = R::select(slips, brakes - pushes, one);
        let drag = R::select(slips, pushes * inertia / excess, drag);
        let most = (R::lit(STICKIEST) * (bars.trace() + mass + mass)).detach();
        let drag = R::select(drag.less(most), drag, most);
        let sticks = (infinite & held) | (stays & stuck & !slips) | rests;
        let hold = Hold {
            segment,
            is_held: truth(held),
            sticks: truth(sticks),
            is_new: truth(is_new),
            impact,
            slip,
            drag: R::select(infinite, zero, drag),
            slid: R::select(slides, speed, zero),
        };
        let [ex, ey] = self.0.correction(&over, &hold).array();
        let [a, b, c, d, e, f, g, h] = hold.array();
        [a, b, c, d, e, f, g, h, ex, ey]
    }
}

/// The kernel of a node's equation. The inputs are the change of velocity of held nodes, the velocity at the base of the
/// linearisation, the velocity without bars, the impulse of the forces (N s), 1 / mass, and of the [`Hold`] the segment,
/// `is_held`, `sticks`, `slip` and `drag`. The results are the right-hand side (N s), the node's block of the matrix
/// (kg), and the projection onto its held directions.
#[derive(Clone, Debug)]
pub(crate) struct Equation<G>(pub(crate) G);

impl<G: Underfoot> Kernel<14, 8> for Equation<G> {
    #[inline(always)]
    fn eval<R: Real>(&self, input: [R; 14]) -> [R; 8] {
        let [ex, ey, vx, vy, fx, fy, jx, jy, inverse_mass, rest @ ..] = input;
        let [segment, is_held, sticks, slip, drag] = rest;
        let plane = self.0.plane(segment);
        let tangent = (plane.axes).out_of_rotated(Vector::upright(R::one(), R::zero()));
        let moving = Vector::new([vx, vy]) + Vector::new([ex, ey]);
        let unexplained = residual(
            moving,
            Vector::new([fx, fy]),
            Vector::new([jx, jy]),
            inverse_mass,
        );
        let slides = plane.axes.into_rotated(moving).forward() - slip;
        let [bx, by] = (-(unexplained + tangent * (drag * slides))).array();
        let mass = inverse_mass.recip();
        let [xx, xy, yy] = Symmetric::scaling(tangent, mass + drag, mass).array();
        let [fxx, fxy, fyy] = Symmetric::scaling(tangent, sticks, is_held).array();
        [bx, by, xx, xy, yy, fxx, fxy, fyy]
    }
}

/// The impulse (N s) that bars do not explain if a node moves with the velocity `moving`, and with `free` without bars.
#[inline(always)]
fn residual<R: Real>(
    moving: Vector<R>,
    free: Vector<R>,
    impulse: Vector<R>,
    inverse_mass: R,
) -> Vector<R> {
    (moving - free) / inverse_mass - impulse
}

/// The kernel of a node's [`Equation`] in a world without ground. The inputs are the first nine; the results are the
/// right-hand side and the block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeEquation;

impl Kernel<7, 5> for FreeEquation {
    #[inline(always)]
    fn eval<R: Real>(&self, [vx, vy, fx, fy, jx, jy, inverse_mass]: [R; 7]) -> [R; 5] {
        let reaction = Reaction.eval([vx, vy, fx, fy, jx, jy, inverse_mass]);
        let mass = inverse_mass.recip();
        [-reaction[0], -reaction[1], mass, R::zero(), mass]
    }
}

/// The kernel of the impulse (N s) that the ground must give a node. The inputs are its velocity in the step, the velocity
/// without bars, the impulse of the forces, and 1 / mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction;

impl Kernel<7, 2> for Reaction {
    #[inline(always)]
    fn eval<R: Real>(&self, [wx, wy, fx, fy, jx, jy, inverse_mass]: [R; 7]) -> [R; 2] {
        let (moving, free) = (Vector::new([wx, wy]), Vector::new([fx, fy]));
        residual(moving, free, Vector::new([jx, jy]), inverse_mass).array()
    }
}

/// The kernel that ends a step. The inputs are the position, the velocity in the step, and of the [`Hold`] the segment,
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

impl<C: Contact, G: Underfoot> UniformKernel<9, 4> for Landing<C, G> {
    const UNIFORMS: usize = C::COUNT;

    #[inline(always)]
    fn eval_with<R: Real>(
        &self,
        [x, y, wx, wy, segment, is_held, sticks, slip, slid]: [R; 9],
        settings: &Uniforms<R>,
    ) -> [R; 4] {
        let (node, zero) = (Particle::new([x, y, wx, wy]), R::zero());
        let (law, drift) = (self.contact.of(settings), Drift { dt: self.dt });
        let (held, axes) = (mask(is_held), self.ground.plane(segment).axes);
        let but = R::select(held, segment, R::lit(NONE));
        let after = self.ground.drift_but::<C, R, 2>(&law, &drift, node, but);
        let turned = after.v - node.v;
        let again = zero.less(turned.forward().abs() + turned.up().abs());
        let velocity = axes.into_rotated(node.v);
        let rest = R::lit(self.dt);
        let braked = axes.out_of_rotated(C::respond(&law, Impact { velocity, rest }));
        // Coulomb friction would have stopped a node that the drag has slowed down by more than half.
        let half = R::lit(0.5) * slid;
        let stops = mask(sticks) | (velocity.forward() - slip).abs().less(half);
        let resting = Vector::select(stops, Vector::zero(), braked);
        let v = Vector::select(held & !again, resting, after.v);
        Particle { x: after.x, v }.array()
    }
}
