//! Contact in an implicit step: nodes that touch the ground are held while the velocities are solved for, so that bars
//! feel the ground in the same step.
//!
//! A step solves once or more; each time is a *pass*. Before a pass, the kernels of this file decide which nodes are held,
//! which of these stick, and how friction brakes the others. After the last pass, the nodes move. The choices have no
//! derivative; everything else has one. `tests/data/implicit/README.md` explains the algorithm, and why it is as it is.

use autodiff::Real;
use autodiff_programs::kernels::{constants, pulled_back, seeded};
use autodiff_programs::{Compiled, Kernel, Pullback};

use super::contact::{Contact, Impact, OverGround, Surface};
use super::motion::{Drift, Particle};
use super::terrain::NONE;
use crate::geometry::{Plane, Rotation, Symmetric, Vector};
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

/// The contacts of all nodes in a pass. Every field has a number for each node. Yes is 1, and no is 0.
#[derive(Clone, Debug)]
pub(crate) struct NodeContacts<A> {
    pub(crate) ground: GroundBelow<A>,
    /// Whether the node is held: it cannot move into the ground or off it.
    pub(crate) is_held: A,
    /// Whether the node is also held along the ground.
    pub(crate) sticks: A,
    /// The time from the beginning of the step until the node meets the ground, s.
    pub(crate) impact: A,
    /// The mean velocity along the ground, m/s, of a node that stops there at the impact: one component, and in space a
    /// second one across.
    pub(crate) slip: Vec<A>,
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
    /// The unit vector along the segment: its components forward and up, because a segment is inclined along the first axis.
    pub(crate) tangent: [A; 2],
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
    const COMPILED: Compiled = C::COMPILED.at_most(Compiled::Seldom);
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

in_both_dimensions! { D =>
    #[kernel]
    impl<G: Surface> Kernel<{ 2 * D + 2 }, 5> for FindGround<G> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, x: [R; 2 * D + 2], _: &[R]) -> [R; 5] {
            let (node, before) = Particle::<R, D>::split(&x);
            let (segment, is_held) = (before[0], before[1]);
            let (meets, met) = self.ground.meets(node, self.dt);
            let is_new = meets & !mask(is_held);
            let segment = R::select(is_new, met, segment).detach();
            let found = [segment, truth(is_new)];
            below(found, self.ground.plane(segment), node.x)
        }

        // The search runs without tangents, because it has no derivative.
        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, { 2 * D + 2 }, 5, M>,
        ) -> [[R; 2 * D + 2]; M] {
            let [segment, is_new, ..] = at.y;
            let plane = self.ground.plane(segment).constant();
            let x = Vector::<_, D>::first_of(&seeded(at.x));
            let found = constants(&[segment, is_new]);
            pulled_back(below(found, plane, x), at.y_bar)
        }
    }
}

/// The numbers of [`GroundBelow`]: the segment and whether the node is new there, the tangent of the plane of the segment, and
/// the height of the node above it.
#[inline(always)]
fn below<R: Real, const D: usize>(
    [segment, is_new]: [R; 2],
    plane: Plane<R>,
    x: Vector<R, D>,
) -> [R; 5] {
    let along = Vector::<R, 2>::upright(R::one(), R::zero());
    let [tx, ty] = plane.axes.out_of_rotated(along).array();
    [segment, is_new, tx, ty, plane.height(x)]
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
    fn new(
        tangent: Vector<R, 2>,
        height: R,
        is_new: R::Mask,
        moving: Vector<R, D>,
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

/// The kernel of the first pass. The inputs are the velocity, the velocity with which the node would move without bars, and
/// of the ground below it whether the node is newly held, the tangent and the height (m). The uniform input is the
/// [grip](Contact::grip). The results are whether the node sticks, its time of impact (s) and its slip (m/s), and the change of velocity of held nodes.
#[derive(Clone, Debug)]
pub struct FirstPass<const D: usize> {
    /// The duration of the step, s.
    pub dt: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 2 * D + 4 }, { 2 * D + 1 }> for FirstPass<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = 1;

        fn eval<R: Real>(&self, node: [R; 2 * D + 4], given: &[R]) -> [R; 2 * D + 1] {
            let ([v, moving], ground) = Vector::<R, D>::split(&node);
            let (meets, tangent) = (mask(ground[0]), Vector::first_of(&ground[1..]));
            let local = LocalNode::new(tangent, ground[3], meets, moving, self.dt);
            // A node that lands or slides is free along the ground in this pass, so that a false stop does not spoil its
            // reaction.
            let rests = meets & local.rests(v, given[0]);
            let slip = local.moving.along() * (local.impact / R::lit(self.dt));
            let slip = Vector::select(meets & !rests, slip, Vector::zero());
            let mut results = [R::zero(); 2 * D + 1];
            results[0] = truth(rests);
            results[1] = R::select(meets, local.impact, R::zero());
            slip.write_along(&mut results[2..]);
            local.correction(meets, rests, slip, self.dt).write(&mut results[D + 1..]);
            results
        }

        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, { 2 * D + 4 }, { 2 * D + 1 }, M>,
        ) -> [[R; 2 * D + 4]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// The kernel of the later passes. The inputs are those of [`FirstPass`], where the second vector is the velocity of the
/// pass before. Then come 1 / mass, and from the pass before: whether the node was held, stuck, and newly held, its time of
/// impact (s), its slip (m/s), and the impulse that the ground gave it (N s); at last the node's block of the matrix of bars
/// in the first pass (kg). The results are whether the node is held and sticks, its time of impact, its slip, the drag of
/// friction (kg), the speed from which friction slows it down (m/s), and the change of velocity of held nodes.
#[derive(Clone, Debug)]
pub struct NextPass<const D: usize> {
    /// The duration of the step, s.
    pub dt: f64,
}

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 4 * D + 8 + D * (D + 1) / 2 }, { 2 * D + 4 }> for NextPass<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        const UNIFORMS: usize = 1;

        fn eval<R: Real>(
            &self,
            node: [R; 4 * D + 8 + D * (D + 1) / 2],
            given: &[R],
        ) -> [R; 2 * D + 4] {
            let ([v, moving], rest) = Vector::<R, D>::split(&node);
            let (is_new, tangent, height) = (rest[0], Vector::first_of(&rest[1..]), rest[3]);
            let (inverse_mass, is_held, sticks) = (rest[4], rest[5], rest[6]);
            let (was_new, impact, rest) = (rest[7], rest[8], &rest[9..]);
            let (slip, rest) = (Vector::<R, D>::along_of(rest), &rest[D - 1..]);
            let ([reaction], bars) = Vector::<R, D>::split(rest);
            let (zero, one, least, dt) = (R::zero(), R::one(), R::lit(LEAST), R::lit(self.dt));
            let (grip, is_new, was_new) = (given[0], mask(is_new), mask(was_new));
            let (was_held, stuck, infinite) =
                (mask(is_held), mask(sticks), R::lit(INFINITE).less(grip));
            let local = LocalNode::new(tangent, height, is_new, moving, self.dt);
            let along = local.moving.along();

            // A held node stays as long as the ground pushes it; others are held if they would end in the ground.
            let reaction = local.axes.into_rotated(reaction);
            let stays = was_held & zero.less(reaction.up());
            let held = stays | is_new;
            let rests = is_new & local.rests(v, grip);
            let impact = R::select(is_new, local.impact, impact);
            let lands = (is_new | was_new) & !stuck & !rests;
            let slip = Vector::select(lands, along * (impact / dt), slip);
            let speed = (along - slip).norm_along();

            // Friction: at most `grip` times the impulse out of the ground. A new node has no such impulse yet, so that of
            // its own mass counts.
            let (pushes, brakes) = (grip * reaction.up().max(zero), reaction.norm_along());
            let slips = stays & stuck & !infinite & pushes.less(brakes);
            let slides = stays & !stuck;
            let own = grip * local.moving.up().abs() / inverse_mass * (one - local.impact / dt);
            let slowest = R::select(speed.less(least), least, speed);
            let drag = R::select(is_new, own, pushes) / slowest;
            let drag = R::select(slides | is_new, drag, zero);
            let (bars, mass) = (Symmetric::<R, D>::first_of(bars), inverse_mass.recip());
            let towards = direction(tangent, reaction, R::select(slips, brakes, one));
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
            let mut results = [zero; 2 * D + 4];
            (results[0], results[1], results[2]) = (truth(held), truth(sticks), impact);
            slip.write_along(&mut results[3..]);
            results[D + 2] = R::select(infinite, zero, drag);
            results[D + 3] = R::select(slides, speed, zero);
            local.correction(held, sticks, slip, self.dt).write(&mut results[D + 4..]);
            results
        }

        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, { 4 * D + 8 + D * (D + 1) / 2 }, { 2 * D + 4 }, M>,
        ) -> [[R; 4 * D + 8 + D * (D + 1) / 2]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// The kernel of a node's equation. The inputs are the change of velocity of held nodes, the velocity at the base of the
/// linearisation, the velocity without bars, the impulse of the forces (N s), 1 / mass, the tangent of the ground, whether
/// the node is held and sticks, its slip (m/s) and the drag of friction (kg). The results are the right-hand side (N s),
/// the node's block of the matrix (kg), and the projection onto its held directions.
#[derive(Clone, Copy, Debug)]
pub struct Equation<const D: usize>;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 5 * D + 5 }, { D * (D + 2) }> for Equation<D> {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, node: [R; 5 * D + 5], _: &[R]) -> [R; D * (D + 2)] {
            let ([change, base, free, impulse], rest) = Vector::<R, D>::split(&node);
            let (inverse_mass, tangent) = (rest[0], Vector::first_of(&rest[1..]));
            let (is_held, sticks, slip) = (rest[3], rest[4], Vector::<R, D>::along_of(&rest[5..]));
            let drag = rest[D + 4];
            let (axes, moving) = (Rotation::with_tangent(tangent), base + change);
            let unexplained = residual(moving, free, impulse, inverse_mass);
            let slides = axes.into_rotated(moving).along() - slip;
            let braked = axes.out_of_plane(slides * drag);
            let mass = inverse_mass.recip();
            let mut equation = [R::zero(); D * (D + 2)];
            (-(unexplained + braked)).write(&mut equation);
            let (blocks, triangle) = (&mut equation[D..], D * (D + 1) / 2);
            Symmetric::<R, D>::of_plane(tangent, mass + drag, mass).write(blocks);
            Symmetric::<R, D>::of_plane(tangent, sticks, is_held).write(&mut blocks[triangle..]);
            equation
        }

        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, { 5 * D + 5 }, { D * (D + 2) }, M>,
        ) -> [[R; 5 * D + 5]; M] {
            self.emitted_vjp(at)
        }
    }
}

/// The kernel of a node's [`Equation`] in a world without ground. The inputs are those of [`Reaction`]; the results are the
/// right-hand side and the block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeEquation;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 3 * D + 1 }, { D + D * (D + 1) / 2 }> for FreeEquation {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, node: [R; 3 * D + 1], _: &[R]) -> [R; D + D * (D + 1) / 2] {
            let ([moving, free, impulse], inverse_mass) = Vector::<R, D>::split(&node);
            let (reaction, mass) =
                (residual(moving, free, impulse, inverse_mass[0]), inverse_mass[0].recip());
            let mut equation = [R::zero(); D + D * (D + 1) / 2];
            (-reaction).write(&mut equation);
            Symmetric::<R, D>::diagonal(mass).write(&mut equation[D..]);
            equation
        }
    }
}

/// The impulse (N s) that bars do not explain if a node moves with the velocity `moving`, and with `free` without bars.
#[inline(always)]
fn residual<R: Real, const D: usize>(
    moving: Vector<R, D>,
    free: Vector<R, D>,
    impulse: Vector<R, D>,
    inverse_mass: R,
) -> Vector<R, D> {
    (moving - free) / inverse_mass - impulse
}

/// The kernel of the impulse (N s) that the ground must give a node. The inputs are its velocity in the step, the velocity
/// without bars, the impulse of the forces, and 1 / mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction;

in_both_dimensions! { D =>
    #[kernel]
    impl Kernel<{ 3 * D + 1 }, D> for Reaction {
        const COMPILED: Compiled = Compiled::Seldom;
        fn eval<R: Real>(&self, node: [R; 3 * D + 1], _: &[R]) -> [R; D] {
            let ([moving, free, impulse], inverse_mass) = Vector::<R, D>::split(&node);
            residual(moving, free, impulse, inverse_mass[0]).array()
        }
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

impl<C: Contact, G: Surface> Landing<C, G> {
    /// The velocity after the step, m/s. `x` are the inputs of the kernel.
    #[inline(always)]
    fn velocity<R: Real, const D: usize>(
        &self,
        law: &C::Of<R>,
        x: &[R],
        axes: Rotation<R>,
        end: Particle<R, D>,
    ) -> Vector<R, D> {
        let (Particle { v, .. }, rest) = Particle::<R, D>::split(x);
        let (is_held, sticks) = (rest[1], rest[2]);
        let (slip, slid) = (Vector::along_of(&rest[3..]), rest[D + 2]);
        let (zero, rest) = (R::zero(), R::lit(self.dt));
        let again = zero.less((end.v - v).sum_of_sizes());
        let velocity = axes.into_rotated(v);
        let braked = axes.out_of_rotated(C::respond(law, Impact { velocity, rest }));
        // Coulomb friction would have stopped a node that the drag has slowed down by more than half.
        let half = R::lit(0.5) * slid;
        let stops = mask(sticks) | (velocity - slip).norm_along().less(half);
        let resting = Vector::select(stops, Vector::zero(), braked);
        Vector::select(mask(is_held) & !again, resting, end.v)
    }
}

in_both_dimensions! { D =>
    #[kernel]
    impl<C: Contact, G: Surface> Kernel<{ 3 * D + 3 }, { 2 * D }> for Landing<C, G> {
        const COMPILED: Compiled = C::COMPILED.at_most(Compiled::Seldom);
        const UNIFORMS: usize = C::COUNT;

        fn eval<R: Real>(&self, x: [R; 3 * D + 3], settings: &[R]) -> [R; 2 * D] {
            let (law, node, but) = self.before(x, settings);
            let drift = Drift { dt: self.dt };
            let end = (self.ground).drift_but::<C, R, D>(&law, &drift, node, but);
            self.after(&law, x, self.ground.plane(but).axes, end)
        }

        fn vjp<R: Real, const M: usize>(
            &self,
            at: Pullback<R, { 3 * D + 3 }, { 2 * D }, M>,
        ) -> [[R; 3 * D + 3]; M] {
            self.ground.vjp(self, at)
        }
    }

    impl<C: Contact, G: Surface> OverGround<C, D, { 3 * D + 3 }, { 2 * D }> for Landing<C, G> {
        #[inline(always)]
        fn drift(&self) -> Drift {
            Drift { dt: self.dt }
        }

        #[inline(always)]
        fn before<R: Real>(
            &self,
            x: [R; 3 * D + 3],
            settings: &[R],
        ) -> (C::Of<R>, Particle<R, D>, R) {
            let (node, rest) = Particle::split(&x);
            let but = R::select(mask(rest[1]), rest[0], R::lit(NONE));
            (self.contact.of(settings), node, but)
        }

        #[inline(always)]
        fn after<R: Real>(
            &self,
            law: &C::Of<R>,
            x: [R; 3 * D + 3],
            axes: Rotation<R>,
            end: Particle<R, D>,
        ) -> [R; 2 * D] {
            let v = self.velocity(law, &x, axes, end);
            Particle { x: end.x, v }.array()
        }
    }
}
