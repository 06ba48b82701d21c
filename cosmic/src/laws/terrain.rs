//! Terrain: the segments of a ground's profile, and the first of them that a node meets.
//!
//! A profile is a function of the place along the ground: at any time a node is over exactly one segment.
//! The corners cut its way into stays, one over each segment, and a node meets the first segment of which
//! it is below the line before it leaves. Stays that follow one another end and begin at one number: no
//! node slips through a corner by rounding.

use std::sync::Arc;

use autodiff::{Mask, Real};

use crate::ground::Profile;

/// What a profile looks like to kernels.
#[derive(Clone, Debug)]
pub struct Terrain {
    segments: Arc<[Segment]>,
}

/// A part of the terrain that is straight, in the ground's frame.
#[derive(Clone, Copy, Debug)]
struct Segment {
    /// The unit vector along it.
    along: [f64; 2],
    /// The distance of its line from the origin of the frame, along its normal, m.
    offset: f64,
    /// Where it ends, m along the ground; it begins where the one before it ends.
    end: f64,
}

/// Points that are no farther from a line are on it but for rounding, m.
const ON_LINE: f64 = 1e-12;

impl Terrain {
    /// The terrain of a profile; `None` if the ground is its line.
    pub fn new(profile: &Profile) -> Option<Self> {
        let points = profile.points();
        let (first, last) = (points.first()?, points.last()?);
        let level = [1.0, 0.0];
        let mut segments = vec![Segment::new(*first, level, first[0])];
        for ends in points.windows(2) {
            match segments.last_mut() {
                // A corner between parts of one line is none: a node slides across without an impact.
                Some(last) if last.above(ends[1]).abs() < ON_LINE => last.end = ends[1][0],
                _ => segments.push(Segment::new(
                    ends[0],
                    direction(ends[0], ends[1]),
                    ends[1][0],
                )),
            }
        }
        match segments.last_mut() {
            Some(segment) if segment.along == level => segment.end = f64::INFINITY,
            _ => segments.push(Segment::new(*last, level, f64::INFINITY)),
        }
        let segments = segments.into();
        Some(Self { segments })
    }

    /// The first segment, other than the one of the number `but`, that a node meets on its way. Nothing
    /// of it carries a derivative.
    #[inline(always)]
    pub(super) fn meet<R: Real>(&self, way: &Way<R>, but: R) -> Meeting<R> {
        let (zero, least) = (R::zero(), R::lit(LEAST_SPEED));
        let ([x, _], [vx, _]) = (way.place, way.velocity);
        // A node that goes straight up or down stays over its segment.
        let per_way = R::select(vx.abs().less(least), least, vx).recip();
        let mut met = Meeting::none(way);
        let mut enters = R::lit(f64::NEG_INFINITY) * per_way;
        let (mut earliest, mut last_met) = (way.left, way.left);
        for k in 0..self.segments.len() {
            let segment = &self.segments[k];
            let (number, offset) = (R::lit(k as f64), R::lit(segment.offset));
            let along = [R::lit(segment.along[0]), R::lit(segment.along[1])];
            // The stay over the segment, within the way. Going back, it is left where it begins.
            let leaves = (R::lit(segment.end) - x) * per_way;
            let first = enters.min(leaves).max(zero);
            let last = enters.max(leaves).min(way.left);
            enters = leaves;
            let (height, out) = (
                height(along, offset, way.place),
                normal(along, way.velocity),
            );
            let sinks = last.fma(out, height).less(zero) & out.less(zero);
            let is_other = number.less(but) | but.less(number);
            let is_met = sinks & is_other & first.less(last) & first.less(earliest);
            earliest = R::select(is_met, first, earliest);
            last_met = R::select(is_met, last, last_met);
            met.touches = met.touches | is_met;
            met.segment = R::select(is_met, number, met.segment);
            met.along = select(is_met, along, met.along);
            met.offset = R::select(is_met, offset, met.offset);
        }
        let slack = R::lit(SLACK) * way.left;
        met.within = [(earliest - slack).max(zero), last_met];
        met.detached()
    }
}

/// A node that slides into a corner meets the other side when it gets there: rounding alone decides which of
/// the two times is the larger one. By this share of the way the impact may be the earlier one, so that its
/// time is the one at which the side is met, with its derivative, and not the bound, without one.
const SLACK: f64 = 1e-3;

/// Speeds along the ground below this are none, m/s; it is a normal number in single precision too.
const LEAST_SPEED: f64 = 1e-30;

impl Segment {
    fn new(point: [f64; 2], along: [f64; 2], end: f64) -> Self {
        let offset = along[0] * point[1] - along[1] * point[0];
        Self { along, offset, end }
    }

    /// The height of a point above the segment's line, m.
    fn above(&self, point: [f64; 2]) -> f64 {
        height(self.along, self.offset, point)
    }
}

fn direction(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let way = [to[0] - from[0], to[1] - from[1]];
    way.map(|w| w / way[0].hypot(way[1]))
}

/// The component of a vector out of a segment.
#[inline(always)]
fn normal<R: Real>([cos, sin]: [R; 2], [x, y]: [R; 2]) -> R {
    cos.fma(y, -(sin * x))
}

/// The height of a place above a segment's line, m.
#[inline(always)]
fn height<R: Real>(along: [R; 2], offset: R, [x, y]: [R; 2]) -> R {
    let [cos, sin] = along;
    cos.fma(y, (-sin).fma(x, -offset))
}

/// Vector `a` where the mask holds, else `b`.
#[inline(always)]
pub(super) fn select<R: Real>(mask: R::Mask, a: [R; 2], b: [R; 2]) -> [R; 2] {
    [R::select(mask, a[0], b[0]), R::select(mask, a[1], b[1])]
}

/// A node on its way, in the ground's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way<R> {
    /// Where it is, m.
    pub(super) place: [R; 2],
    /// Its velocity, m/s.
    pub(super) velocity: [R; 2],
    /// The time that is left, s.
    pub(super) left: R,
}

/// The segment that a node meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting<R: Real> {
    /// False if it meets none.
    pub(super) touches: R::Mask,
    /// The number of the segment; -1 for none.
    pub(super) segment: R,
    along: [R; 2],
    offset: R,
    /// When the node may meet the segment, s.
    within: [R; 2],
}

impl<R: Real> Meeting<R> {
    #[inline(always)]
    fn none(way: &Way<R>) -> Self {
        Self {
            touches: R::Mask::splat(false),
            segment: R::lit(NONE),
            along: [R::one(), R::zero()],
            offset: R::zero(),
            within: [R::zero(), way.left],
        }
    }

    /// Derivatives go through the impact itself, not through the search for it: which segment is met, and
    /// between which corners, is constant but at the corners. The adjoint leaves out all of the search.
    #[inline(always)]
    fn detached(self) -> Self {
        let [cos, sin] = self.along;
        let [first, last] = self.within;
        Self {
            touches: self.touches,
            segment: self.segment.detach(),
            along: [cos.detach(), sin.detach()],
            offset: self.offset.detach(),
            within: [first.detach(), last.detach()],
        }
    }

    /// The node where it meets the segment, its velocity along the segment and out of it; a node that
    /// meets none, at the end of its way. The time of impact passes no derivative at its bounds (D9).
    #[inline(always)]
    pub(super) fn reached(&self, way: &Way<R>) -> Way<R> {
        let ([cos, sin], [vx, vy]) = (self.along, way.velocity);
        let local = [cos.fma(vx, sin * vy), normal(self.along, way.velocity)];
        let approach = R::select(self.touches, local[1], -R::one());
        let height = height(self.along, self.offset, way.place);
        let [first, last] = self.within;
        let time = (-height / approach).clamp(first, last);
        let moving = R::select(self.touches, time, way.left);
        Way {
            place: moved(way.place, moving, way.velocity),
            velocity: local,
            left: way.left - moving,
        }
    }

    /// A vector along the segment and out of it in the ground's frame.
    #[inline(always)]
    pub(super) fn in_ground(&self, [along, out]: [R; 2]) -> [R; 2] {
        let [cos, sin] = self.along;
        [cos.fma(along, -(sin * out)), sin.fma(along, cos * out)]
    }
}

/// The number of no segment.
pub(super) const NONE: f64 = -1.0;

/// A place after a time at a velocity.
#[inline(always)]
pub(super) fn moved<R: Real>([x, y]: [R; 2], time: R, [vx, vy]: [R; 2]) -> [R; 2] {
    [time.fma(vx, x), time.fma(vy, y)]
}
