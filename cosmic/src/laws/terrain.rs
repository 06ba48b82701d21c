//! Terrain: the segments of a ground's profile, and the first of them that a node meets.
//!
//! A profile is a function of the position along the ground, so a node is over exactly one segment at any time. The
//! corners divide its path into stays, one over each segment. The node meets the first segment below whose line it gets
//! before it leaves that segment. A stay begins at exactly the number at which the stay before it ends, so that no node
//! slips through a corner by rounding.

use std::sync::Arc;

use autodiff::{Mask, Real};

use super::motion::Particle;
use crate::geometry::{Plane, Profile, Rotation, Vector};

/// A profile in the form that kernels use.
#[derive(Clone, Debug)]
pub struct Terrain {
    segments: Arc<[Segment]>,
}

/// A straight part of the terrain, in the ground's frame.
#[derive(Clone, Copy, Debug)]
struct Segment {
    plane: Plane<f64>,
    /// The position along the ground at which it ends, m. The next segment begins there.
    end: f64,
}

/// Points at most this far from a line are on it, apart from rounding, m.
const ON_LINE: f64 = 1e-12;

impl Terrain {
    /// The terrain of a profile; `None` if the ground is its line.
    pub fn new(profile: &Profile) -> Option<Self> {
        let points = profile.points();
        let (first, last) = (*points.first()?, *points.last()?);
        let level = Rotation::NONE;
        let mut segments = vec![Segment::new(first, level, first.forward())];
        for ends in points.windows(2) {
            let (from, to) = (ends[0], ends[1]);
            match segments.last_mut() {
                // Points on one line make no corner: a node slides across without an impact.
                Some(last) if last.plane.height(to).abs() < ON_LINE => last.end = to.forward(),
                _ => segments.push(Segment::new(
                    from,
                    Rotation::towards(from, to),
                    to.forward(),
                )),
            }
        }
        match segments.last_mut() {
            Some(segment) if segment.plane.axes == level => segment.end = f64::INFINITY,
            _ => segments.push(Segment::new(last, level, f64::INFINITY)),
        }
        let segments = segments.into();
        Some(Self { segments })
    }

    /// The first segment that a node meets on its way, except the segment with the number `but`. The result carries no
    /// derivative.
    #[inline(always)]
    pub(super) fn meet<R: Real, const D: usize>(&self, way: &Way<R, D>, but: R) -> Meeting<R> {
        let (zero, least) = (R::zero(), R::lit(LEAST_SPEED));
        let Particle { x, v } = way.node;
        // A node that moves straight up or down stays over its segment.
        let speed = R::select(v.forward().abs().less(least), least, v.forward());
        let per_way = speed.recip();
        let mut met = Meeting::none(way.left);
        let mut enters = R::lit(f64::NEG_INFINITY) * per_way;
        let (mut earliest, mut last_met) = (way.left, way.left);
        for k in 0..self.segments.len() {
            let segment = &self.segments[k];
            let (number, plane) = (R::lit(k as f64), segment.plane.lit());
            // The stay over the segment, within the way. A node that moves back leaves a segment at its beginning.
            let leaves = (R::lit(segment.end) - x.forward()) * per_way;
            let first = enters.min(leaves).max(zero);
            let last = enters.max(leaves).min(way.left);
            enters = leaves;
            let (height, out) = (plane.height(x), plane.axes.out(v));
            let sinks = last.fma(out, height).less(zero) & out.less(zero);
            let is_other = number.less(but) | but.less(number);
            let is_met = sinks & is_other & first.less(last) & first.less(earliest);
            earliest = R::select(is_met, first, earliest);
            last_met = R::select(is_met, last, last_met);
            met.touches = met.touches | is_met;
            met.segment = R::select(is_met, number, met.segment);
            met.plane = Plane::select(is_met, plane, met.plane);
        }
        let slack = R::lit(SLACK) * way.left;
        met.earliest = (earliest - slack).max(zero);
        met.latest = last_met;
        met.detached()
    }
}

/// A node that slides into a corner meets the other side at the moment at which it gets there, so only rounding decides
/// which of the two times is larger. The impact may be earlier by this fraction of the way. Its time is then the time
/// at which the side is met, which has a derivative, and not the bound, which has none.
const SLACK: f64 = 1e-3;

/// The smallest speed along the ground, m/s: slower nodes get this speed. It is a normal number in single precision too.
const LEAST_SPEED: f64 = 1e-30;

impl Segment {
    fn new(point: Vector<f64>, axes: Rotation<f64>, end: f64) -> Self {
        let plane = Plane::through(point, axes);
        Self { plane, end }
    }
}

/// A node on its way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way<R, const D: usize = 2> {
    pub(super) node: Particle<R, D>,
    /// The remaining time, s.
    pub(super) left: R,
}

/// The segment that a node meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting<R: Real> {
    /// False if it meets no segment.
    pub(super) touches: R::Mask,
    /// The number of the segment; -1 if there is none.
    pub(super) segment: R,
    plane: Plane<R>,
    /// Bounds on the time of impact, s.
    earliest: R,
    latest: R,
}

impl<R: Real> Meeting<R> {
    #[inline(always)]
    fn none(left: R) -> Self {
        Self {
            touches: R::Mask::splat(false),
            segment: R::lit(NONE),
            plane: Plane::LEVEL.lit(),
            earliest: R::zero(),
            latest: left,
        }
    }

    /// Derivatives go through the impact, not through the search for it: which segment is met is constant except at
    /// corners. So the adjoint does not contain the search.
    #[inline(always)]
    fn detached(self) -> Self {
        Self {
            touches: self.touches,
            segment: self.segment.detach(),
            plane: self.plane.detach(),
            earliest: self.earliest.detach(),
            latest: self.latest.detach(),
        }
    }

    /// The node where it meets the segment, with its velocity along and out of the segment; or at the end of its way if
    /// it meets no segment. The time of impact passes no derivative at its bounds (D9).
    #[inline(always)]
    pub(super) fn reached<const D: usize>(&self, way: &Way<R, D>) -> Way<R, D> {
        let Particle { x, v } = way.node;
        let local = self.plane.axes.into_rotated(v);
        let approach = R::select(self.touches, local.up(), -R::one());
        let time = (-self.plane.height(x) / approach).clamp(self.earliest, self.latest);
        let moving = R::select(self.touches, time, way.left);
        Way {
            node: Particle {
                x: way.node.after(moving).x,
                v: local,
            },
            left: way.left - moving,
        }
    }

    /// A vector with components along and out of the segment, in the ground's frame.
    #[inline(always)]
    pub(super) fn in_ground<const D: usize>(&self, vector: Vector<R, D>) -> Vector<R, D> {
        self.plane.axes.out_of_rotated(vector)
    }
}

/// Stands for "no segment".
pub(super) const NONE: f64 = -1.0;
