//! The share of an implicit step after which the forces are taken: 1 is the end of the step, which damps vibrations; near
//! one half the step is of second order.
//!
//! In a step in which a node lands, the share is 1 for the whole robot: otherwise the end of the step would throw a stiff
//! body off the ground. Which nodes land is a choice without a derivative.

use autodiff::{AnyProgram, Array, Kernel, Real};

use crate::geometry::Vector;
use crate::laws::{Step, Tensions, Under, mask, truth};

/// The speed into the ground above which a node lands, m/s. A node that rests has exactly 0.
const LANDS: f64 = 1e-6;

/// The share of a recorded step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Theta {
    /// The share, for every node.
    of_nodes: Array,
    /// The share, for every slot of the graph.
    of_slots: Array,
    /// Whether a node lands in this step, for every node: 1 or 0.
    lands: Array,
}

impl Theta {
    /// The share of a step: `share`, unless a node lands. `under` is the ground under the nodes if they move without bars;
    /// `None` in a world without ground. `none` is a zero for every node.
    pub(super) fn of(
        p: &mut AnyProgram,
        share: f64,
        step: &Step,
        under: Option<Under<Array>>,
        none: Array,
    ) -> Self {
        let lands = under.map_or(none, |under| {
            let ([vx, vy], [tx, ty]) = (step.nodes.v.array(), under.tangent.array());
            p.map(Lands, [vx, vy, tx, ty, under.is_new])[0]
        });
        let [_, mean] = p.weighted(step.inverse_mass, &[lands], &[], &[]);
        let mut each = |count| {
            let mean = p.gather(mean, &vec![Some(0); count]);
            p.map(Share(share), [mean])[0]
        };
        Self {
            of_nodes: each(step.graph.nodes()),
            of_slots: each(step.graph.slots()),
            lands,
        }
    }

    /// The velocities without bars, given those at the start (`v`) and at the end of the step.
    pub(super) fn free(
        &self,
        p: &mut AnyProgram,
        v: Vector<Array>,
        free: Vector<Array>,
    ) -> Vector<Array> {
        let ([vx, vy], [fx, fy]) = (v.array(), free.array());
        Vector::new(p.map(Between, [vx, vy, fx, fy, self.of_nodes]))
    }

    /// Vectors of the nodes times the share.
    pub(super) fn times(&self, p: &mut AnyProgram, of_nodes: Vector<Array>) -> Vector<Array> {
        let [x, y] = of_nodes.array();
        Vector::new(p.map(Times, [x, y, self.of_nodes]))
    }

    /// The tensions that the linear function of a bar needs so that its impulse is that of the share.
    pub(super) fn tensions(&self, p: &mut AnyProgram, of: Tensions) -> Tensions {
        let [tension, by_length] = p.map(Times, [of.tension, of.by_length, self.of_slots]);
        Tensions {
            tension,
            by_length,
            by_rate: of.by_rate,
        }
    }

    /// The slopes of a bar's impulse times the share.
    pub(super) fn slopes(&self, p: &mut AnyProgram, [xx, xy, yy]: [Array; 3]) -> [Array; 3] {
        let [xx, xy] = p.map(Times, [xx, xy, self.of_slots]);
        let [yy, _] = p.map(Times, [yy, yy, self.of_slots]);
        [xx, xy, yy]
    }

    /// The impulses of bars in the whole step, given those of the share.
    pub(super) fn whole(&self, p: &mut AnyProgram, [x, y]: [Array; 2]) -> [Array; 2] {
        p.map(Whole, [x, y, self.of_slots])
    }

    /// The velocities in the middle of the whole step, given those at its start and at the end of the share.
    pub(super) fn midway(&self, p: &mut AnyProgram, [vx, vy, wx, wy]: [Array; 4]) -> [Array; 2] {
        p.map(Midway, [vx, vy, wx, wy, self.of_nodes])
    }

    /// The velocities at the end of the step. `v` are those at its start, `moving` those with which nodes move in it, and
    /// `after` what the ground leaves of these. Free nodes go on as they began. A node that lands keeps its velocity, so
    /// that the next step, which takes the rest of it, also has the share 1.
    pub(super) fn end(
        &self,
        p: &mut AnyProgram,
        [v, moving, after]: [Vector<Array>; 3],
        is_held: Array,
    ) -> Vector<Array> {
        let ([vx, vy], [wx, wy], [ax, ay]) = (v.array(), moving.array(), after.array());
        let node = [vx, vy, wx, wy, ax, ay, is_held, self.lands, self.of_nodes];
        Vector::new(p.map(Onward, node))
    }
}

/// The kernel that tells whether a node lands: 1 or 0. The inputs are its velocity at the start of the step, the tangent of
/// the ground under it, and whether it meets the ground.
struct Lands;

impl Kernel<5, 1> for Lands {
    #[inline(always)]
    fn eval<R: Real>(&self, [vx, vy, tx, ty, is_new]: [R; 5]) -> [R; 1] {
        // The component into the ground, along the tangent turned to the right.
        let into = vx * ty - vy * tx;
        [truth(mask(is_new) & R::lit(LANDS).less(into))]
    }
}

/// The kernel of the share, from the mean over all nodes of whether they land.
struct Share(f64);

impl Kernel<1, 1> for Share {
    #[inline(always)]
    fn eval<R: Real>(&self, [lands]: [R; 1]) -> [R; 1] {
        [R::select(R::zero().less(lands), R::one(), R::lit(self.0))]
    }
}

/// The kernel of a vector between two others, after a share of the way.
struct Between;

impl Kernel<5, 2> for Between {
    #[inline(always)]
    fn eval<R: Real>(&self, [ax, ay, bx, by, share]: [R; 5]) -> [R; 2] {
        let (a, b) = (Vector::new([ax, ay]), Vector::new([bx, by]));
        (a + (b - a) * share).array()
    }
}

/// The kernel of two numbers times the share.
struct Times;

impl Kernel<3, 2> for Times {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, share]: [R; 3]) -> [R; 2] {
        [x * share, y * share]
    }
}

/// The kernel of two numbers divided by the share.
struct Whole;

impl Kernel<3, 2> for Whole {
    #[inline(always)]
    fn eval<R: Real>(&self, [x, y, share]: [R; 3]) -> [R; 2] {
        [x / share, y / share]
    }
}

/// The kernel of [`Theta::midway`].
struct Midway;

impl Kernel<5, 2> for Midway {
    #[inline(always)]
    fn eval<R: Real>(&self, [vx, vy, wx, wy, share]: [R; 5]) -> [R; 2] {
        let (v, w) = (Vector::new([vx, vy]), Vector::new([wx, wy]));
        ((w - v) * (R::lit(0.5) / share) + v).array()
    }
}

/// The kernel of [`Theta::end`].
struct Onward;

impl Kernel<9, 2> for Onward {
    #[inline(always)]
    fn eval<R: Real>(&self, [vx, vy, wx, wy, ax, ay, is_held, lands, share]: [R; 9]) -> [R; 2] {
        let (v, moving, after) = (
            Vector::new([vx, vy]),
            Vector::new([wx, wy]),
            Vector::new([ax, ay]),
        );
        let (turned, held) = (after - moving, mask(is_held));
        let is_free = !held & !R::zero().less(turned.forward().abs() + turned.up().abs());
        let onward = v + (moving - v) / share;
        let landed = Vector::select(held & mask(lands), moving, after);
        Vector::select(is_free, onward, landed).array()
    }
}
